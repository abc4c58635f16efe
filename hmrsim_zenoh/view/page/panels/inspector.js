// The selected robot: its state and the reason, its goal and equipment, and buttons for requests.

import { actionWords, causeWords, faultWords, lengthWords, pointWords, shareWords, taskWords, whyWords } from '../model/phrases.js';
import { Facts, TypeSign, button, el, mark, say, sign } from './dom.js';

export class Inspector {
  constructor(app) {
    this.app = app;
    [this.name, this.state, this.charge] = ['h2', 'b', 'b'].map((tag) => el(tag));
    this.type = el('span', { class: 'type' });
    this.dot = new TypeSign(app);
    this.shape = sign('state', '');
    this.why = el('span', { class: 'why' });
    this.goal = el('p', { class: 'goal-line' });
    this.meter = el('div', { class: 'meter', role: 'meter', 'aria-label': 'Battery', 'aria-valuemin': 0, 'aria-valuemax': 100 }, el('i'));
    this.battery = el('div', { class: 'battery' }, el('span', { text: 'Battery' }), this.meter, this.charge);
    this.facts = new Facts();
    this.element = el('section', { class: 'card inspector', 'aria-label': 'Selected robot', hidden: true },
      el('header', {}, this.dot.element, el('div', {}, this.name, this.type),
        button('close', 'Close', () => app.select(null), { key: 'esc', class: 'quiet' })),
      el('p', { class: 'state-line', role: 'status' }, this.shape, this.state, this.why),
      this.goal, this.battery, this.#makeButtons(), this.facts.element);
  }

  #makeButtons() {
    const { orders, live, map } = this.app;
    const make = (icon, label, act, more = {}) => button(icon, label, () => act(map.selected), { text: true, ...more });
    this.go = make('target', 'Go to', (name) => this.app.aim(name), { class: 'primary', key: 'm' });
    this.act = make('goals', 'Action…', (name) => orders.fillInGoal(name), { key: 'a' });
    this.dock = make('dock', 'Dock', (name) => (this.#robot.dock ? orders.undock(name) : orders.sendToDock(name)));
    this.cancel = make('stop', 'Cancel', (name) => orders.cancelAll(name));
    this.fault = make('fault', 'Fault…', (robot) => orders.fillInFault({ robot }));
    this.follow = make('follow', 'Follow', (name) => this.app.follow(name), { key: 'f' });
    return el('div', { class: 'actions' }, ...(live ? [this.go, this.act, this.dock, this.cancel, this.fault] : []), this.follow);
  }

  get #robot() { return this.app.model.robots.get(this.app.map.selected); }

  render() {
    const robot = this.#robot;
    this.element.hidden = !robot;
    if (!robot) return;
    const { model, model: { world } } = this.app;
    const now = this.app.now();
    const state = robot.stateAt(now);
    const left = robot.distanceRemaining(now);
    const way = left > 0 ? ` · ${lengthWords(left, world.units)} left` : '';
    say(this.name, robot.name);
    say(this.type, `${robot.type}${robot.flies ? ', flies' : ''}`);
    this.dot.show(robot.type, robot.flies);
    mark(this.shape, 'data-is', state);
    say(this.state, state);
    say(this.why, whyWords(robot, state, model, now));
    say(this.goal, robot.goal ? taskWords(robot.goal, world) + way : 'no goal');
    mark(this.goal, 'data-none', !robot.goal);
    this.#renderBattery(robot);
    this.#renderButtons(robot);
    this.#renderFacts(robot, now);
  }

  #renderBattery({ battery }) {
    this.battery.hidden = !battery;
    if (!battery) return;
    const share = battery.percentage;
    this.meter.firstChild.style.width = `${share * 100}%`;
    mark(this.meter, 'aria-valuenow', Math.round(share * 100));
    mark(this.meter, 'data-level', share < 0.1 ? 'critical' : share < 0.25 ? 'low' : 'good');
    say(this.charge, `${shareWords(share)}${battery.charging ? ', charging' : ''}`);
  }

  #renderButtons(robot) {
    const may = (action) => robot.actions.length === 0 || robot.actions.includes(action);
    const gone = !this.app.commanding;
    this.go.disabled = gone || !may('navigate_to_pose');
    this.dock.disabled = gone || (!may('dock_robot') && !robot.dock);
    this.dock.hidden = this.app.model.docks.size === 0;
    say(this.dock.lastChild, robot.dock ? 'Undock' : 'Dock');
    this.act.disabled = gone || robot.actions.length === 0;
    this.cancel.disabled = gone || robot.goals.length === 0;
    this.fault.disabled = gone;
    mark(this.follow, 'aria-pressed', this.app.map.follow === robot.name);
  }

  #renderFacts(robot, now) {
    const { model } = this.app;
    const [x, y, yaw] = robot.poseAt(now);
    const waiting = [...model.robots.values()].filter((other) => other.heldBy(model).includes(robot.name));
    const behind = robot.goals.filter((goal) => goal !== robot.goal);
    this.facts.show([
      ['Position', `${pointWords([x, y], 'm')} · ${Math.round((yaw * 180) / Math.PI)}°`],
      ['Dock', robot.dock],
      ['Carries', robot.holds.join(', ')],
      ['Faults', faultWords(robot, model)],
      ['Held up by', causeWords(robot, model, now)],
      ['Blocks', waiting.map(({ name }) => name).join(', ')],
      ['Other goals', behind.map((goal) => taskWords(goal, model.world)).join(', ')],
      ['Components', robot.components.map(actionWords).join(', ')],
      ['Planner', robot.planner === 'external' ? 'external planner' : ''],
      ['Detections', robot.detections.map(({ id }) => id).join(', ')],
    ].filter(([, value]) => value));
  }
}
