// The list of robots: state, battery and goal of each; a click follows one.

import { STATES } from '../model/robot.js';
import { ListPanel, TypeSign, el, mark, say, sign } from './dom.js';
import { faultWords, shareWords, taskWords, whyWords } from '../model/phrases.js';

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
    else this.rows.show(this.shown);
  }

  /** Filter and sort the robots. */
  changed() {
    const now = this.app.now();
    const { robots } = this.app.model;
    const { text } = this;
    const key = ORDERS[this.order.value];
    const found = [];
    for (const robot of robots.values()) if (!text || this.#line(robot, now).includes(text)) found.push([key(robot, now), robot]);
    found.sort(([a, one], [b, other]) => (a === b ? byName(one.name, other.name) : a < b ? -1 : 1));
    this.shown = found.map(([, robot]) => robot);
    this.known = robots.size;
    this.arranged = performance.now();
    this.rows.show(this.shown, robots.size ? 'No robot matches.' : 'The world has no robots.');
  }

  #line(robot, now) {
    const state = robot.stateAt(now);
    return `${robot.name} ${robot.type} ${state} ${whyWords(robot, state, this.app.model, now)} ${faultWords(robot, this.app.model)} ${this.#task(robot)}`.toLowerCase();
  }

  #task({ goal }) {
    return goal ? taskWords(goal, this.app.model.world) : '';
  }

  row() {
    const { app } = this;
    const type = new TypeSign(app);
    const state = sign('state', '');
    const [name, word, why, task, fault] = ['b', 'span', 'span', 'span', 'span'].map((tag) => el(tag));
    const warning = sign('level', 'error');
    const battery = el('span', { class: 'long' });
    name.className = 'name';
    task.className = why.className = fault.className = 'detail';
    let robot = null;
    const press = el('button', { type: 'button', class: 'robot-row', onclick: () => app.follow(robot.name) }, type.element,
      el('span', { class: 'robot-main' }, el('span', { class: 'robot-line' }, name, task),
        el('span', { class: 'robot-line muted' }, state, word, why, warning, fault)), battery);
    const row = el('div', {}, press);
    row.fill = (given) => {
      robot = given;
      const now = app.now();
      const is = robot.stateAt(now);
      type.show(robot.type, robot.flies);
      say(name, robot.name);
      say(task, this.#task(robot));
      mark(state, 'data-is', is);
      say(word, is);
      say(why, whyWords(robot, is, app.model, now));
      const faults = faultWords(robot, app.model);
      warning.hidden = !faults;
      say(fault, is === 'stopped' || is === 'offline' ? '' : faults);
      say(battery, robot.battery ? shareWords(robot.battery.percentage) : '');
      mark(press, 'data-selected', String(robot.name === app.map.selected));
      mark(press, 'aria-pressed', String(robot.name === app.map.follow));
      mark(press, 'title', `${robot.name}, ${robot.type}: click to follow`);
    };
    return row;
  }
}
