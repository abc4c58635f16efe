// Plots of any number in any topic, which a person chooses.

import { Line } from '../model/history.js';
import { numberAt, numbersIn, timeIn } from '../model/topics.js';
import { button, el } from './dom.js';

const EVERY = 0.5; // wall seconds between two values
const GAP = 0.1; // the least seconds between two values
const LOOK = 1; // wall seconds between two looks at the topics
const MAX_PLOTS = 4;
const MAX_ROBOTS = 8;
/** The topics of the world that have numbers. */
const WORLD = ['_world/time/state', '_world/demand'];

export class Plots {
  constructor(app) {
    this.app = app;
    this.all = []; // the plots: their title, `lines` by robot, or by "" for a topic of the world, elements, and how to `end`
    this.topics = new Map(); // the numbers of each topic, without the robot's name
    this.topic = el('select', { class: 'field', 'aria-label': 'Topic', onchange: () => this.#offer() });
    this.field = el('select', { class: 'field', 'aria-label': 'Number' });
    this.adder = button('plus', 'Plot', () => this.add(this.topic.value, this.field.value), { text: true });
    this.list = el('div');
    this.element = el('div', {}, el('h3', { text: 'Topics' }), el('div', { class: 'plot-tools' }, this.topic, this.field, this.adder), this.list);
    this.ends = []; // the functions that end looking for topics
    this.#offer();
  }

  /** @param {boolean} seen Whether the plots are shown; only then are topics looked for. */
  seen(seen) {
    this.ends.splice(0).forEach((end) => end());
    if (!seen) return;
    const { connection, playback } = this.app;
    const [robot = ''] = this.#robots();
    if (playback && !this.topics.size) for (const [, key, payload] of playback.samples()) this.#find(key, payload);
    if (!connection) return;
    for (const key of WORLD) this.ends.push(this.#follow(key, (payload) => this.#find(key, payload)));
    if (robot) this.ends.push(connection.subscribe(`${robot}/**`, (payload, key) => this.#find(key, payload), { latest: true, every: LOOK }));
  }

  /** Offer a topic that has numbers. */
  #find(key, payload) {
    const topic = WORLD.includes(key) ? key : key.slice(key.indexOf('/') + 1);
    if (key.startsWith('_world/') && !WORLD.includes(key)) return;
    const known = this.topics.get(topic) ?? new Set();
    const count = known.size;
    if (!count || !this.app.playback) for (const path of numbersIn(payload)) known.add(path);
    if (known.size === count) return;
    this.topics.set(topic, known);
    this.#offer();
  }

  #offer() {
    const names = [...this.topics.keys()].sort((a, b) => a.startsWith('_') - b.startsWith('_') || (a < b ? -1 : 1));
    refill(this.topic, names.length ? names : ['No topics yet']);
    refill(this.field, [...(this.topics.get(this.topic.value) ?? [])].sort());
    this.adder.disabled = !this.field.value || this.all.length >= MAX_PLOTS;
  }

  /** Plot a number of the selected robot, or else of the first robots. */
  add(topic, field) {
    const owners = WORLD.includes(topic) ? [''] : this.#robots();
    const lines = new Map(owners.map((owner) => [owner, new Line(GAP)]));
    const take = (owner, message, time) => {
      const value = numberAt(message, field);
      if (value !== undefined) lines.get(owner).add(timeIn(message) ?? time, value);
    };
    const keys = new Map(owners.map((owner) => [owner ? `${owner}/${topic}` : topic, owner]));
    const ends = this.app.connection ? Array.from(keys, ([key, owner]) => this.#follow(key, (message) => take(owner, message, this.app.clock.live()))) : [];
    for (const [time, key, message] of this.app.playback?.samples() ?? []) if (keys.has(key)) take(keys.get(key), message, time);
    const title = `${topic} · ${field}`;
    const [chart, legend] = [el('div', { class: 'chart', role: 'img' }), el('ul', { class: 'legend-line' })];
    const plot = { title, lines, chart, legend, end: () => ends.forEach((end) => end()) };
    plot.element = el('section', { 'aria-label': title }, el('div', { class: 'plot-title' }, el('h3', { text: title }),
      button('close', 'Remove this plot', () => this.#remove(plot), { class: 'quiet small' })), chart, legend);
    this.all.push(plot);
    this.list.append(plot.element);
    this.#offer();
  }

  /** Take the latest message of a topic, and further ones. @returns {() => void} Ends that. */
  #follow(key, take) {
    const { connection } = this.app;
    void connection.getAll(key).then((replies) => replies.forEach(([, message]) => take(message)), () => {}); // Some topics have no latest.
    return connection.subscribe(key, take, { latest: true, every: EVERY });
  }

  #remove(plot) {
    plot.end();
    plot.element.remove();
    this.all.splice(this.all.indexOf(plot), 1);
    this.#offer();
  }

  /** Return the selected robot, or else the first robots. */
  #robots() {
    const { map: { selected }, model } = this.app;
    return selected === null ? [...model.robots.keys()].slice(0, MAX_ROBOTS) : [selected];
  }
}

/** Set the options of a choice, and keep the chosen one if it is still there. */
function refill(select, names) {
  const { value } = select;
  select.replaceChildren(...names.map((name) => el('option', { text: name, value: name })));
  if (names.includes(value)) select.value = value;
}
