// The frame of the page: summary, side panel, legend and theme.

import { STATES, countStates } from '../model/robot.js';
import { TypeSign, button, dash, el, icon, mark, recall, remember, say, sign } from './dom.js';

export class Summary {
  constructor(app) {
    this.app = app;
    this.world = el('h1', { text: 'hmrsim' });
    this.counts = STATES.map((state) => {
      const count = el('span');
      return { state, count, item: el('li', {}, sign('state', state), count, el('span', { class: 'unseen', text: state })) };
    });
    const list = el('ul', { class: 'counts', 'aria-label': 'Robots by state' }, ...this.counts.map(({ item }) => item));
    this.element = el('div', { class: 'summary' }, this.world, list);
  }

  render() {
    const { model, playback } = this.app;
    const name = playback?.name ? `${model.world.name} · ${playback.name}` : model.world.name;
    say(this.world, name);
    if (document.title !== `${name} · hmrsim`) document.title = `${name} · hmrsim`;
    const numbers = countStates(model.robots, this.app.now());
    for (const { state, count, item } of this.counts) {
      say(count, numbers[state]);
      item.hidden = numbers[state] === 0;
      mark(item, 'title', `${numbers[state]} ${state}`);
    }
  }
}

export class Side {
  constructor(app, panels) {
    this.app = app;
    this.panels = panels;
    this.open = null;
    this.title = el('h2', { id: 'side-title' });
    this.body = el('div', { class: 'side-body' });
    this.element = el('aside', { class: 'side', 'aria-labelledby': 'side-title', hidden: true },
      el('header', {}, el('span', { class: 'grip', 'aria-hidden': 'true' }), this.title,
        button('close', 'Close', () => this.show(null), { key: 'esc', class: 'quiet' })), this.body);
    this.buttons = new Map(Object.entries(panels).map(([name, { title }]) =>
      [name, button(name, title, () => this.toggle(name), { key: name[0], text: true, class: 'tab' })]));
    this.tabs = el('div', { class: 'tabs', role: 'group', 'aria-label': 'Panels' }, ...this.buttons.values());
  }

  toggle(name) { this.show(this.open === name ? null : name); }

  show(name) {
    const next = this.panels[name] ? name : null;
    if (next === this.open) return;
    this.panels[this.open]?.seen?.(false);
    this.open = next;
    for (const [each, tab] of this.buttons) mark(tab, 'aria-expanded', each === next);
    this.element.hidden = next === null;
    mark(document.body, 'data-panel', next ?? 'none');
    if (next !== null) {
      say(this.title, this.panels[next].title);
      this.body.replaceChildren(this.panels[next].element);
      this.panels[next].seen?.(true);
    }
    this.app.layout();
    this.render();
  }

  render() {
    if (this.open !== null) this.panels[this.open].render();
  }
}

const LAYERS = {
  walls: 'Walls', lanes: 'Lanes', names: 'Names', routes: 'Path ahead', driven: 'Path driven', sensors: 'Sensors',
};
const LINES = [['ahead', 'path ahead'], ['driven', 'path driven'], ['lane_closed', 'closed lane, fault'], ['charger', 'charger'], ['door', 'door'], ['item', 'item']];

export class Legend {
  constructor(app) {
    this.app = app;
    const { layers } = app.map;
    const shown = Object.entries(LAYERS).map(([layer, label]) => el('label', {}, el('input', {
      type: 'checkbox', checked: layers[layer], onchange: ({ target }) => (layers[layer] = target.checked),
    }), label));
    [this.types, this.lines] = [el('ul'), el('ul')];
    this.element = el('section', { class: 'card legend', id: 'legend', 'aria-label': 'Legend and layers', hidden: true },
      el('fieldset', {}, el('legend', { text: 'Show' }), ...shown),
      el('h3', { text: 'Robot states' }), el('ul', {}, ...STATES.map((state) => el('li', {}, sign('state', state), state))),
      el('h3', { text: 'Robot types' }), this.types, el('h3', { text: 'Map' }), this.lines);
    app.model.addEventListener('world', () => this.render());
  }

  toggle() {
    this.element.hidden = !this.element.hidden;
    this.render();
  }

  render() {
    mark(this.app.legendButton, 'aria-expanded', !this.element.hidden);
    if (this.element.hidden) return;
    const { model: { robots, world }, palette, theme } = this.app;
    const used = new Set(Array.from(robots.values(), ({ type }) => type));
    this.types.replaceChildren(...[...world.types.keys()].filter((type) => used.has(type)).map((type) => {
      const shape = new TypeSign(this.app);
      shape.show(type);
      return el('li', {}, shape.element, type);
    }));
    this.lines.replaceChildren(...LINES.map(([color, text]) => el('li', {}, dash(palette[theme.name][color]), text)));
  }
}

const DARK = matchMedia('(prefers-color-scheme: dark)');
const KEY = 'hmrsim.theme';

export class Theme {
  constructor(app) {
    this.app = app;
    /** @type {'dark'|'light'} */
    this.name = 'light';
    this.button = button('sun', 'Dark or light', () => this.toggle(), { key: 'd' });
    for (const [state, color] of Object.entries(app.palette.states)) {
      document.documentElement.style.setProperty(`--${state}`, color);
    }
    DARK.addEventListener('change', () => this.begin());
  }

  begin() { this.set(this.app.asked.get('theme') ?? recall(KEY) ?? (DARK.matches ? 'dark' : 'light')); }

  toggle() {
    this.set(this.name === 'dark' ? 'light' : 'dark');
    remember(KEY, this.name);
  }

  set(name) {
    this.name = name === 'dark' ? 'dark' : 'light';
    document.documentElement.dataset.theme = this.name;
    this.app.map.theme = this.name;
    this.button.replaceChildren(icon(this.name === 'dark' ? 'sun' : 'moon'));
    this.app.legend.render();
    this.app.render();
  }
}
