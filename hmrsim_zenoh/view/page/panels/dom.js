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
  if (element.textContent !== text) element.textContent = text;
}

/** Set an attribute if it has changed. */
export function mark(element, name, value) {
  if (element.getAttribute(name) !== value) element.setAttribute(name, value);
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

/** The strokes of each icon, in a square of 24. */
const ICONS = {
  play: 'M8 5.5v13l10-6.5z',
  pause: 'M8.5 5.5v13M15.5 5.5v13',
  step: 'M6 5.5v13l8.5-6.5zM18 5.5v13',
  next: 'M5 5.5v13l7-6.5zM12 5.5v13l7-6.5z',
  previous: 'M19 5.5v13l-7-6.5zM12 5.5v13l-7-6.5z',
  robots: 'M4.5 11h9v8h-9zM10 11V6.5h9.5v8.5h-6M7 14.5h.01M11 14.5h.01M14.7 2.8v3.7',
  goals: 'M6 21V4M6 4.5h11l-2.5 4L17 12.5H6',
  orders: 'M8.5 5H5.5v15.5h13V5h-3M8.5 3.5h7v3.5h-7zM9 11.5h6M9 15.5h4',
  events: 'M8.5 6.5H20M8.5 12H20M8.5 17.5H20M4 6.5h.01M4 12h.01M4 17.5h.01',
  trees: 'M9 3.5h6v4.5H9zM3.5 16h6v4.5h-6zM14.5 16h6v4.5h-6zM12 8v4M6.5 16v-4h11v4',
  charts: 'M4 4v16h16M7.5 15.5l4-5 3 3 5-7',
  search: 'M10.5 4a6.5 6.5 0 1 0 0 13a6.5 6.5 0 0 0 0-13zM15.5 15.5L20.5 20.5',
  plus: 'M12 5.5v13M5.5 12h13',
  minus: 'M5.5 12h13',
  fit: 'M4.5 9V4.5H9M15 4.5h4.5V9M19.5 15v4.5H15M9 19.5H4.5V15',
  layers: 'M12 3.5l8.5 4.5-8.5 4.5L3.5 8zM3.5 12.5l8.5 4.5 8.5-4.5M3.5 16.5l8.5 4.5 8.5-4.5',
  sun: 'M12 8a4 4 0 1 0 0 8a4 4 0 0 0 0-8zM12 2.5v2M12 19.5v2M2.5 12h2M19.5 12h2M5.3 5.3l1.4 1.4M17.3 17.3l1.4 1.4M18.7 5.3l-1.4 1.4M6.7 17.3l-1.4 1.4',
  moon: 'M20 14.5A8.5 8.5 0 1 1 9.5 4a7 7 0 0 0 10.5 10.5z',
  help: 'M9 9a3 3 0 1 1 4.2 2.8c-.8.4-1.2 1-1.2 1.9v.6M12 18h.01',
  close: 'M6 6l12 12M18 6L6 18',
  target: 'M12 6a6 6 0 1 0 0 12a6 6 0 0 0 0-12zM12 2.5v5M12 16.5v5M2.5 12h5M16.5 12h5',
  follow: 'M12 8.5a3.5 3.5 0 1 0 0 7a3.5 3.5 0 0 0 0-7zM4 9V4h5M15 4h5v5M20 15v5h-5M9 20H4v-5',
  dock: 'M13 2.5L5.5 13.5H11L10 21.5 18.5 10H12.5z',
  fault: 'M12 4L2.5 20h19zM12 10v4.5M12 17.5h.01',
  stop: 'M7 7h10v10H7z',
  check: 'M5 12.5l4.5 4.5L19 7.5',
  down: 'M7 10l5 5 5-5',
  right: 'M10 7l5 5-5 5',
  robot: 'M5.5 9h13v9.5h-13zM12 9V5M9.5 13.5h.01M14.5 13.5h.01',
  place: 'M12 21s-6.5-6-6.5-11a6.5 6.5 0 0 1 13 0c0 5-6.5 11-6.5 11zM12 10h.01',
  item: 'M4.5 8L12 4l7.5 4v8L12 20l-7.5-4zM4.5 8L12 12l7.5-4M12 12v8',
  door: 'M6.5 21V3.5h11V21M3.5 21h17M14 12.5h.01',
  lane: 'M7 4v16M17 4v16M12 5v3M12 10.5v3M12 16v3',
};

/** Return a decorative icon. */
export function icon(name) {
  const [svg, path] = ['svg', 'path'].map((tag) => document.createElementNS('http://www.w3.org/2000/svg', tag));
  for (const [key, value] of Object.entries({ viewBox: '0 0 24 24', class: 'icon', 'aria-hidden': 'true' })) svg.setAttribute(key, value);
  path.setAttribute('d', ICONS[name] ?? '');
  svg.append(path);
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

const SPARE = 4; // rows above and below the visible ones

/** Return a value that the browser remembers for this page; null if there is none, undefined if storage is disabled. */
export function recall(key) { return ifStored(() => localStorage.getItem(key)); }

/** Remember a value in the browser, if its settings allow that. */
export function remember(key, value) {
  ifStored(() => localStorage.setItem(key, value));
}

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

/** A list of any length of which only visible rows exist. @template T */
class Rows {
  /**
   * @param {number} options.height The height of a row in css pixels.
   * @param {() => HTMLElement & {fill: (item: T) => void}} options.make Returns a new row, which is filled repeatedly.
   */
  constructor({ label, height, make, role = 'list' }) {
    this.empty = el('p', { class: 'empty' }); // shown instead of the rows if there are none
    this.height = height;
    this.make = make;
    this.rowRole = role === 'table' ? 'row' : 'listitem';
    this.body = el('div', { class: 'rows-body', role: 'presentation' });
    this.element = el('div', { class: 'rows', role, 'aria-label': label, tabindex: '0' }, this.body);
    // Reading these from the element would force a layout each time.
    this.top = this.seen = 0;
    this.element.addEventListener('scroll', () => this.#moved(), { passive: true });
    new ResizeObserver(() => this.#moved()).observe(this.element);
    this.items = [];
    this.pool = [];
  }

  show(items, note = '') {
    this.items = items;
    say(this.empty, items.length ? '' : note);
    this.empty.hidden = items.length > 0;
    this.element.hidden = items.length === 0;
    const height = `${items.length * this.height}px`;
    if (this.body.style.height !== height) this.body.style.height = height;
    mark(this.element, this.rowRole === 'row' ? 'aria-rowcount' : 'data-count', String(items.length));
    this.#draw();
  }

  /** Scroll to the first row. */
  toTop() { this.element.scrollTop = this.top = 0; }

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

/** A panel with a list, and tools above it such as a filter. */
export class ListPanel {
  constructor(app, title, filter, rows) {
    Object.assign(this, { app, title });
    const changed = () => this.changed();
    this.filter = el('input', {
      type: 'search', class: 'field', placeholder: filter, 'aria-label': `Filter ${title.toLowerCase()}`, oninput: changed,
    });
    this.rows = new Rows({ label: title, make: () => this.row(), ...rows });
  }

  /** Put the tools above the list. */
  place(...tools) { this.element = el('div', { class: 'panel-body' }, ...tools, this.rows.empty, this.rows.element); }

  /** Show the list after a change of a tool. */
  changed() { this.render(); }

  /** Return the text to search for, in lower case. */
  get text() { return this.filter.value.trim().toLowerCase(); }
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
