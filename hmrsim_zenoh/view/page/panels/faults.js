// A dialog in which a fault is chosen for a robot, a lane or a door.

import { button, el } from './dom.js';
import { actionWords } from './phrases.js';

/** By what they hit; each with the fields that it has, and what goes without saying. */
const KINDS = {
  robot: {
    breakdown: {},
    slip: { factor: 0.5 },
    battery_cell: {},
    sensor_blind: {},
    claw_drops: {},
    claw_misses: { probability: 1 },
    localisation_jump: { dx: 1, dy: 0, yaw: 0 },
    messages_lost: {},
  },
  lane: { lane_closed: {} },
  door: { door_jammed: {} },
};
const MEANS = {
  breakdown: 'It stands where it is; its goal is aborted and its lane closed.',
  slip: 'It drives at this factor times its speed.',
  battery_cell: 'A cell of its battery fails: it holds less.',
  sensor_blind: 'Its sensors see nothing.',
  claw_drops: 'What its claw holds falls.',
  claw_misses: 'Each pickup fails with this probability.',
  localisation_jump: 'Its odometry is off by so much.',
  messages_lost: 'Nothing that it publishes arrives, and goals are rejected.',
  lane_closed: 'Nobody enters the lane, in either direction.',
  door_jammed: 'The door stays as it is, open or closed.',
};

export class FaultDialog {
  /** @param {import('../app.js').App} app */
  constructor(app) {
    this.app = app;
    this.title = el('h2', { id: 'fault-title' });
    this.type = el('select', { class: 'field', onchange: () => this.#fields() });
    this.means = el('p', { class: 'note' });
    this.own = el('div', { class: 'fields' });
    this.lasts = el('input', { type: 'number', class: 'field', min: '0', step: 'any', placeholder: 'until it is cleared' });
    const form = el('form', { method: 'dialog', onsubmit: (event) => this.#submit(event) }, this.title,
      el('label', {}, el('span', { text: 'What' }), this.type), this.means, this.own,
      el('label', {}, el('span', { text: 'For how many seconds' }), this.lasts),
      el('div', { class: 'actions' }, el('button', { type: 'button', class: 'button', text: 'Leave it', onclick: () => this.element.close() }),
        el('button', { type: 'submit', class: 'button primary', text: 'Inject' })));
    this.element = el('dialog', { class: 'dialog', 'aria-labelledby': 'fault-title' },
      button('close', 'Close', () => this.element.close(), { class: 'quiet corner' }), form);
  }

  /** @param {{robot?: string, lane?: string[], door?: string}} target */
  open(target) {
    this.target = target;
    const [kind, name] = Object.entries(target)[0];
    this.kinds = KINDS[kind];
    this.title.textContent = `A fault of ${kind === 'robot' ? '' : `${kind} `}${Array.isArray(name) ? name.join(' – ') : name}`;
    this.type.replaceChildren(...Object.keys(this.kinds).map((type) => el('option', { value: type, text: actionWords(type) })));
    this.#fields();
    this.element.showModal();
  }

  #fields() {
    this.means.textContent = MEANS[this.type.value];
    this.inputs = Object.entries(this.kinds[this.type.value]).map(([field, value]) => {
      const input = el('input', { type: 'number', class: 'field', step: 'any', value, name: field });
      return [el('label', {}, el('span', { text: field }), input), input];
    });
    this.own.replaceChildren(...this.inputs.map(([label]) => label));
  }

  #submit(event) {
    event.preventDefault();
    const fault = { type: this.type.value, ...this.target };
    for (const [, input] of this.inputs) fault[input.name] = Number(input.value);
    if (Number(this.lasts.value) > 0) fault.duration = Number(this.lasts.value);
    this.element.close();
    this.app.orders.inject(fault);
  }
}
