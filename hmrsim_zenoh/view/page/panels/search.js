// Find a robot, place, dock or item by its name.

import { el, icon, mark } from './dom.js';

const MAX_FOUND = 40;
const ICON = { robot: 'robot', place: 'place', dock: 'dock', item: 'item', door: 'door', waypoint: 'lane' };

export class Search {
  constructor(app) {
    this.app = app;
    this.found = [];
    this.at = -1;
    this.list = el('div', {
      class: 'found', id: 'found', role: 'listbox', 'aria-label': 'Found', hidden: true,
      // Pressing on the list must not take the focus before the click arrives.
      onpointerdown: (event) => event.preventDefault(),
    });
    this.input = el('input', {
      type: 'search', class: 'field', placeholder: 'Find a robot or place', role: 'combobox', autocomplete: 'off',
      spellcheck: 'false', 'aria-label': 'Find a robot, place, dock or item', 'aria-expanded': 'false', 'aria-controls': 'found',
      'aria-keyshortcuts': '/', oninput: () => this.#find(), onfocus: () => this.#find(),
      onkeydown: (event) => this.#key(event), onblur: () => this.#open(false),
    });
    this.element = el('div', { class: 'search', role: 'search' }, icon('search'), this.input,
      el('kbd', { text: '/', 'aria-hidden': 'true' }), this.list);
  }

  focus() {
    this.input.focus();
    this.input.select();
  }

  #find() {
    const text = this.input.value.trim().toLowerCase();
    const found = [[], [], []]; // the same name, names that begin with the text, and names that contain it
    for (const kind of Object.keys(ICON)) {
      // There may be many waypoints.
      for (const name of text || kind !== 'waypoint' ? this.app.model.allOf(kind).keys() : []) {
        const where = name.toLowerCase().indexOf(text);
        if (where >= 0) found[where ? 2 : Number(name.length > text.length)].push({ kind, name });
      }
    }
    this.found = found.flat().slice(0, MAX_FOUND);
    this.at = text && this.found.length ? 0 : -1;
    this.#show();
  }

  #show() {
    const options = this.found.map(({ kind, name }, i) => el('div', {
      role: 'option', id: `found-${i}`, class: 'option', 'aria-selected': String(i === this.at), onclick: () => this.#take(i),
    }, icon(ICON[kind]), el('span', { text: name }), el('small', { text: this.#about(kind, name) })));
    this.list.replaceChildren(...(options.length ? options : [el('p', { class: 'empty', text: 'No match.' })]));
    this.#open(true);
    if (this.at >= 0) mark(this.input, 'aria-activedescendant', `found-${this.at}`);
    else this.input.removeAttribute('aria-activedescendant');
  }

  #open(open) {
    this.list.hidden = !open;
    mark(this.input, 'aria-expanded', open);
  }

  #about(kind, name) {
    const sent = this.app.aimed;
    if (kind !== 'robot') return sent === null ? kind : `${kind} · send ${sent} here`;
    const robot = this.app.model.robots.get(name);
    return `${robot.type}, ${robot.stateAt(this.app.now())}`;
  }

  #key(event) {
    const step = { ArrowDown: 1, ArrowUp: -1 }[event.key];
    if (step && this.found.length) {
      this.at = (this.at + step + this.found.length) % this.found.length;
      this.#show();
      this.list.children[this.at].scrollIntoView({ block: 'nearest' });
    } else if (event.key === 'Enter' && this.at >= 0) {
      if (event.shiftKey && this.app.map.selected !== null) this.app.aim(this.app.map.selected);
      this.#take(this.at);
    } else if (event.key === 'Escape') {
      this.#leave();
    } else {
      return;
    }
    event.preventDefault();
    event.stopPropagation();
  }

  #leave() {
    this.input.value = '';
    this.input.blur();
  }

  #take(index) {
    const { kind, name } = this.found[index];
    this.#leave();
    if (kind === 'robot') this.app.select(name, { center: true });
    else if (this.app.aimed !== null) this.app.orders.sendTo(this.app.aimed, kind, name);
    else this.app.centerOn(name, kind);
  }
}
