// The list of robots: state, battery and goal of each; a click follows one.

import { faultWords, shareWords, taskWords, whyWords } from '../model/phrases.js';
import { STATES } from '../model/robot.js';
import { ListPanel, TypeSign, el, mark, say, sign } from './dom.js';

const AGAIN = 1000; // ms after which many robots are sorted again
const MANY = 200;

/** The sort keys of the list; equal robots are ordered by name. */
const ORDERS = {
  Name: () => 0,
  State: (robot, now) => STATES.indexOf(robot.stateAt(now)),
  Battery: (robot) => robot.battery?.percentage ?? 2,
  Goal: (robot) => (robot.goal ? -(robot.goal.accepted ?? 0) : Infinity),
};
const byName = new Intl.Collator(undefined, { numeric: true }).compare;

export class RobotsPanel extends ListPanel {
  constructor(app) {
    super(app, 'Robots', 'Name, type, state, goal', { height: 46 });
    this.order = el('select', { class: 'field', 'aria-label': 'Sort robots by', onchange: () => this.changed() },
      ...Object.keys(ORDERS).map((name) => el('option', { text: name })));
    this.place(el('div', { class: 'tools line' }, this.filter, this.order));
    this.arranged = -Infinity;
    this.shown = [];
  }

  render() {
    const { robots } = this.app.model;
    const wait = robots.size > MANY ? AGAIN : 0;
    if (performance.now() - this.arranged >= wait || robots.size !== this.known) this.changed();
    else this.showItems(this.shown);
  }

  /** Filter and sort the robots. */
  changed() {
    const { robots } = this.app.model;
    const now = this.app.now();
    const key = ORDERS[this.order.value];
    const matching = this.matching([...robots.values()], (robot) => [robot.name, robot.type, ...Object.values(this.#words(robot, now))].join(' '));
    const found = matching.map((robot) => [key(robot, now), robot]);
    found.sort(([a, one], [b, other]) => (a === b ? byName(one.name, other.name) : a < b ? -1 : 1));
    this.shown = found.map(([, robot]) => robot);
    this.known = robots.size;
    this.arranged = performance.now();
    this.showItems(this.shown, robots.size ? 'No robot matches.' : 'The world has no robots.');
  }

  /** Return the words of a robot's state, with the reason, of its goal and of its faults. */
  #words(robot, now) {
    const { model } = this.app;
    const state = robot.stateAt(now);
    const task = robot.goal ? taskWords(robot.goal, model.world) : '';
    return { state, why: whyWords(robot, state, model, now), task, faults: faultWords(robot, model) };
  }

  row() {
    const { app } = this;
    const type = new TypeSign(app);
    const [shape, warning] = [sign('state', ''), sign('level', 'error')];
    const [name, word, battery] = [el('b', { class: 'name' }), el('span'), el('span', { class: 'long' })];
    const [why, task, fault] = [0, 1, 2].map(() => el('span', { class: 'detail' }));
    const press = el('button', { type: 'button', class: 'robot-row', onclick: () => app.follow(row.item.name) }, type.element,
      el('span', { class: 'robot-main' }, el('span', { class: 'robot-line' }, name, task),
        el('span', { class: 'robot-line muted' }, shape, word, why, warning, fault)), battery);
    const row = Object.assign(el('div', {}, press), { parts: { type, shape, warning, name, word, battery, why, task, fault, press } });
    return row;
  }

  fill({ parts }, robot) {
    const { app } = this;
    const words = this.#words(robot, app.now());
    parts.type.show(robot.type, robot.flies);
    say(parts.name, robot.name);
    say(parts.task, words.task);
    mark(parts.shape, 'data-is', words.state);
    say(parts.word, words.state);
    say(parts.why, words.why);
    parts.warning.hidden = !words.faults;
    say(parts.fault, ['stopped', 'offline'].includes(words.state) ? '' : words.faults);
    say(parts.battery, robot.battery ? shareWords(robot.battery.percentage) : '');
    mark(parts.press, 'data-selected', robot.name === app.map.selected);
    mark(parts.press, 'aria-pressed', robot.name === app.map.follow);
    mark(parts.press, 'title', `${robot.name}, ${robot.type}: click to follow`);
  }
}
