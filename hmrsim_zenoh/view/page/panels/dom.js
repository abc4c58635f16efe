// Elements, icons and long lists. Names and errors come from outside: they become text, never markup.

import { drawBody, lookOf } from '../map/shapes.js';

/**
 * Return a new element.
 * @param {Record<string, any>} [given] `class`, `text`, `data` (a record), listeners as `onclick`, other attributes;
 * null, undefined and false are ignored.
 */
export function el(tag, given = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(given)) {
    if (value === null || value === undefined || value === false) continue;
    if (name === 'text') element.textContent = value;
    else if (name === 'class') element.className = value;
    else if (name === 'data') Object.assign(element.dataset, value);
    else if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else element.setAttribute(name, value === true ? '' : String(value));
  }
  element.append(...children.filter((child) => child !== null));
  return element;
}

/** Set a text if it has changed, so that an unchanged one needs no layout. */
export function say(element, text) {
  if (element.textContent !== String(text)) element.textContent = text;
}

/** Set an attribute to a value as text, if it has changed. */
export function mark(element, name, value) {
  if (element.getAttribute(name) !== String(value)) element.setAttribute(name, value);
}

/** Render a part of the page; a failure is shown there, and other parts go on. */
export function guarded(element, render) {
  try {
    render();
    element.removeAttribute('data-failed');
  } catch (error) {
    // Log once, not in each frame.
    if (!element.hasAttribute('data-failed')) console.error(error);
    mark(element, 'data-failed', 'true');
  }
}

/** Return a decorative icon of icons.svg. */
export function icon(name) {
  const [svg, use] = ['svg', 'use'].map((tag) => document.createElementNS('http://www.w3.org/2000/svg', tag));
  svg.setAttribute('class', 'icon');
  svg.setAttribute('aria-hidden', 'true');
  use.setAttribute('href', `icons.svg#${name}`);
  svg.append(use);
  return svg;
}

/** Return a button with an icon, and a label that is visible or only a tooltip. */
export function button(picture, label, onclick, { text = false, key = '', class: kind = '' } = {}) {
  const hint = key ? `${label} (${key})` : label;
  const names = text ? { title: key ? hint : null } : { 'aria-label': label, title: hint };
  const keys = { 'aria-keyshortcuts': /^[a-z0-9/.+-]$/i.test(key) ? key : null };
  return el('button', { type: 'button', class: `button ${kind}`.trim(), onclick, ...names, ...keys }, icon(picture),
    text ? el('span', { text: label }) : null);
}

/**
 * Return a span that shows a word by shape and color, as defined in `style.css`.
 * @param {string} group `state`, `status` or `tree`.
 */
export function sign(group, word) {
  return el('span', { class: `sign ${group}`, data: { is: word }, 'aria-hidden': 'true' });
}

/** Return a dash of a color, for legends. */
export function dash(color) {
  const element = el('span', { class: 'dash', 'aria-hidden': 'true' });
  element.style.background = color;
  return element;
}

/** Return a value that the browser remembers for this page; null if there is none, undefined if storage is disabled. */
export function recall(key) { return ifStored(() => localStorage.getItem(key)); }

/** Remember a value in the browser, if its settings allow that. */
export function remember(key, value) { ifStored(() => localStorage.setItem(key, value)); }

function ifStored(call) {
  try {
    return call();
  } catch {
    return undefined; // The page works without it.
  }
}

/** Show a button that plays or pauses, with the tooltip of its action. */
export function showPlayButton(element, playing, label, hint = ' (space)') {
  element.replaceChildren(icon(playing ? 'pause' : 'play'));
  mark(element, 'aria-label', label);
  mark(element, 'title', `${label}${hint}`);
}

/** A list of terms and values, which is rendered again only if it has changed. */
export class Facts {
  element = el('dl', { class: 'facts' });

  show(facts) {
    const said = JSON.stringify(facts);
    if (said === this.said) return;
    this.said = said;
    this.element.replaceChildren(...facts.flatMap(([key, value]) => [el('dt', { text: key }), el('dd', { text: value })]));
  }
}

const SPARE = 4; // rows above and below the visible ones

/**
 * A panel with a list of any length, of which only visible rows exist, and tools above it such as a filter. A subclass has
 * `row`, which returns a new row, and `fill`, which shows an item in a row, again and again; the row's `item` is the latest.
 */
export class ListPanel {
  /** @param {number} options.height The height of a row in css pixels. */
  constructor(app, title, filter, { height, role = 'list' }) {
    Object.assign(this, { app, title, height, items: [], pool: [] });
    this.filter = el('input', {
      type: 'search', class: 'field', placeholder: filter, 'aria-label': `Filter ${title.toLowerCase()}`, oninput: () => this.changed(),
    });
    this.empty = el('p', { class: 'empty' }); // shown instead of the rows if there are none
    this.rowRole = role === 'table' ? 'row' : 'listitem';
    this.body = el('div', { class: 'rows-body', role: 'presentation' });
    this.list = el('div', { class: 'rows', role, 'aria-label': title, tabindex: '0' }, this.body);
    // Reading these from the element would force a layout each time.
    this.top = this.seenHeight = 0;
    this.list.addEventListener('scroll', () => this.#moved(), { passive: true });
    new ResizeObserver(() => this.#moved()).observe(this.list);
  }

  /** Put the tools above the list. */
  place(...tools) { this.element = el('div', { class: 'panel-body' }, ...tools, this.empty, this.list); }

  /** Show the list after a change of a tool. */
  changed() { this.render(); }

  /** Return the text to search for, in lower case. */
  get text() { return this.filter.value.trim().toLowerCase(); }

  /** Return the items that have the text in their words, which a function returns. */
  matching(items, words) {
    const { text } = this;
    return text ? items.filter((item) => words(item).toLowerCase().includes(text)) : items;
  }

  /** Show items, or a note if there are none. */
  showItems(items, note = '') {
    this.items = items;
    say(this.empty, items.length ? '' : note);
    this.empty.hidden = items.length > 0;
    this.list.hidden = items.length === 0;
    const height = `${items.length * this.height}px`;
    if (this.body.style.height !== height) this.body.style.height = height;
    mark(this.list, this.rowRole === 'row' ? 'aria-rowcount' : 'data-count', items.length);
    this.#draw();
  }

  /** Scroll to the first row. */
  toTop() { this.list.scrollTop = this.top = 0; }

  #moved() {
    this.top = this.list.scrollTop;
    this.seenHeight = this.list.clientHeight;
    this.#draw();
  }

  #draw() {
    const first = Math.max(0, Math.floor(this.top / this.height) - SPARE);
    const last = Math.min(this.items.length, Math.ceil((this.top + this.seenHeight) / this.height) + SPARE);
    while (this.pool.length < last - first) {
      const row = this.row();
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
      if (this.rowRole === 'row') mark(row, 'aria-rowindex', index + 1);
      row.item = this.items[index];
      this.fill(row, row.item);
    });
  }
}

/**
 * Return a row of goals or orders, with its `parts`: a sign, a button with a name and its task, and below it a status and a
 * detail.
 * @param {string[]} classes Of task, status and detail.
 * @param {HTMLElement} end The last cell.
 */
export function taskRow(onclick, classes, end) {
  const [task, status, detail] = classes.map((name) => el('span', { class: name || null }));
  const [shape, name] = [sign('status', ''), el('b', { class: 'name' })];
  const press = el('button', { type: 'button', class: 'goal-name', onclick }, name, task);
  const main = el('div', { class: 'goal-main', role: 'cell' }, press, el('div', { class: 'goal-how' }, status, detail));
  const row = el('div', { class: 'goal' }, el('div', { class: 'goal-sign', role: 'cell' }, shape), main, end);
  return Object.assign(row, { parts: { shape, name, task, status, detail, press, main } });
}

const SIZE = 22; // css pixels

/** The body of a robot type as on the map, for lists and the legend. */
export class TypeSign {
  element = el('canvas', { class: 'type-sign', 'aria-hidden': 'true', width: 2 * SIZE, height: 2 * SIZE });

  constructor(app) {
    this.app = app;
  }

  show(type, flies = this.app.model.world.types.get(type)?.flies ?? false) {
    const { palette, theme, model } = this.app;
    const drawn = `${type} ${flies} ${theme.name} ${model.world.typeIndex(type)}`;
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    const c = this.element.getContext('2d');
    c.setTransform(SIZE * 0.92, 0, 0, SIZE * 0.92, SIZE, SIZE);
    c.clearRect(-2, -2, 4, 4);
    drawBody(c, lookOf(model.world.typeIndex(type), palette), flies, palette[theme.name].robot_outline, 0.09);
    mark(this.element, 'title', type);
  }
}
