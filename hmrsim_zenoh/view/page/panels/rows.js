// A list of any length of which only the rows that are seen are made.

import { el, mark } from './dom.js';

const SPARE = 4; // rows above and below what is seen

/** @template T */
export class Rows {
  /**
   * @param {object} options
   * @param {string} options.label
   * @param {number} options.height Css pixels of a row.
   * @param {() => HTMLElement & {fill: (item: T) => void}} options.make A row to be filled, again and again.
   * @param {string} [options.role]
   */
  constructor({ label, height, make, role = 'list' }) {
    this.height = height;
    this.make = make;
    this.rowRole = role === 'table' ? 'row' : 'listitem';
    this.body = el('div', { class: 'rows-body', role: 'presentation' });
    this.element = el('div', { class: 'rows', role, 'aria-label': label, tabindex: '0' }, this.body);
    // To ask the element for these makes the browser lay out the page each time.
    this.top = this.seen = 0;
    this.element.addEventListener('scroll', () => this.#moved(), { passive: true });
    new ResizeObserver(() => this.#moved()).observe(this.element);
    /** @type {T[]} */
    this.items = [];
    this.pool = [];
  }

  /** @param {T[]} items */
  show(items) {
    this.items = items;
    const height = `${items.length * this.height}px`;
    if (this.body.style.height !== height) this.body.style.height = height;
    mark(this.element, this.rowRole === 'row' ? 'aria-rowcount' : 'data-count', String(items.length));
    this.#draw();
  }

  /** Go back to the first row. */
  toTop() {
    this.element.scrollTop = this.top = 0;
  }

  #moved() {
    this.top = this.element.scrollTop;
    this.seen = this.element.clientHeight;
    this.#draw();
  }

  #draw() {
    const first = Math.max(0, Math.floor(this.top / this.height) - SPARE);
    const last = Math.min(this.items.length, Math.ceil((this.top + this.seen) / this.height) + SPARE);
    while (this.pool.length < last - first) {
      const row = this.make();
      row.setAttribute('role', this.rowRole);
      row.classList.add('row');
      row.style.height = `${this.height}px`;
      this.pool.push(row);
      this.body.append(row);
    }
    this.pool.forEach((row, i) => {
      const index = first + i;
      row.hidden = index >= last;
      if (row.hidden) return;
      const top = `translateY(${index * this.height}px)`;
      if (row.style.transform !== top) row.style.transform = top;
      if (this.rowRole === 'row') mark(row, 'aria-rowindex', String(index + 1));
      row.fill(this.items[index]);
    });
  }
}
