// What the signs and colours on the map mean, and which of them are shown.

import { STATES } from '../model/robot.js';
import { el, mark, sign } from './dom.js';
import { TypeSign } from './type_sign.js';

const LAYERS = {
  walls: 'Walls', lanes: 'Lanes', names: 'Names', routes: 'Path ahead', driven: 'Path driven', sensors: 'Sensors',
};
const LINES = [['ahead', 'path ahead'], ['driven', 'path driven'], ['lane_closed', 'closed lane, fault'], ['charger', 'charger'], ['door', 'door'], ['item', 'item']];

export class Legend {
  /** @param {import('../app.js').App} app */
  constructor(app) {
    this.app = app;
    const layers = el('fieldset', {}, el('legend', { text: 'Show' }));
    for (const [layer, label] of Object.entries(LAYERS)) {
      layers.append(el('label', {}, el('input', {
        type: 'checkbox', checked: app.map.layers[layer] !== false, onchange: (event) => (app.map.layers[layer] = event.target.checked),
      }), label));
    }
    this.types = el('ul');
    this.lines = el('ul');
    this.element = el('section', { class: 'card legend', id: 'legend', 'aria-label': 'Legend and layers', hidden: true }, layers,
      el('h3', { text: 'Robot states' }), el('ul', {}, ...STATES.map((state) => el('li', {}, sign('state', state), state))),
      el('h3', { text: 'Robot types' }), this.types, el('h3', { text: 'Map' }), this.lines);
    app.model.addEventListener('world', () => this.render());
  }

  toggle() {
    this.element.hidden = !this.element.hidden;
    this.render();
  }

  render() {
    mark(this.app.legendButton, 'aria-expanded', String(!this.element.hidden));
    if (this.element.hidden) return;
    const dot = (colour, kind, text) => {
      const shape = el('span', { class: kind, 'aria-hidden': 'true' });
      shape.style.background = colour;
      return el('li', {}, shape, text);
    };
    const { app } = this;
    const used = new Set(Array.from(app.model.robots.values(), ({ type }) => type));
    this.types.replaceChildren(...[...app.model.world.types.keys()].filter((type) => used.has(type)).map((type) => {
      const shape = new TypeSign(app);
      shape.show(type);
      return el('li', {}, shape.element, type);
    }));
    this.lines.replaceChildren(...LINES.map(([colour, text]) => dot(app.palette[app.theme.name][colour], 'dash', text)));
  }
}
