// The selected robot: its state and the reason, its goal and equipment, and buttons for requests.

import { Facts, TypeSign, button, el, mark, say, sign } from './dom.js';
import { actionWords, causeWords, faultWords, lengthWords, shareWords, taskWords, whyWords } from '../model/phrases.js';

export class Inspector {
  constructor(app) {
    this.app = app;
    this.name = el('h2');
    this.type = el('span', { class: 'type' });
    this.dot = new TypeSign(app);
    this.shape = sign('state', '');
    this.state = el('b');
    this.why = el('span', { class: 'why' });
    this.goal = el('p', { class: 'goal-line' });
    this.meter = el('div', { class: 'meter', role: 'meter', 'aria-label': 'Battery', 'aria-valuemin': 0, 'aria-valuemax': 100 }, el('i'));
    this.charge = el('b');
    this.battery = el('div', { class: 'battery' }, el('span', { text: 'Battery' }), this.meter, this.charge);
    this.facts = new Facts();
    this.buttons = el('div', { class: 'actions' });
    this.#makeButtons();
    this.element = el('section', { class: 'card inspector', 'aria-label': 'Selected robot', hidden: true },
      el('header', {}, this.dot.element, el('div', {}, this.name, this.type),
        button('close', 'Close', () => app.select(null), { key: 'esc', class: 'quiet' })),
      el('p', { class: 'state-line', role: 'status' }, this.shape, this.state, this.why),
      this.goal, this.battery, this.buttons, this.facts.element);
  }

  #makeButtons() {
    const { app } = this;
    const name = () => app.map.selected;
    this.go = button('target', 'Go to', () => app.aim(name()), { text: true, class: 'primary', key: 'm' });
    this.dock = button('dock', 'Dock', () => this.#dock(), { text: true });
    this.act = button('goals', 'Action…', () => app.orders.fillInGoal(name()), { text: true, key: 'a' });
    this.cancel = button('stop', 'Cancel', () => app.orders.ask(`cancel the goals of ${name()}`, () => app.commands.cancelAll(name())), { text: true });
    this.follow = button('follow', 'Follow', () => app.follow(name()), { text: true, key: 'f' });
    this.fault = button('fault', 'Fault…', () => app.orders.fillInFault({ robot: name() }), { text: true });
    this.buttons.append(...(app.live ? [this.go, this.act, this.dock, this.cancel, this.fault] : []), this.follow);
  }

  #dock() {
    const robot = this.app.model.robots.get(this.app.map.selected);
    if (robot.dock) this.app.orders.undock(robot.name);
    else this.app.orders.sendToDock(robot.name);
  }

  render() {
    const robot = this.app.model.robots.get(this.app.map.selected);
    this.element.hidden = !robot;
    if (!robot) return;
    const now = this.app.now();
    const state = robot.stateAt(now);
    say(this.name, robot.name);
    say(this.type, `${robot.type}${robot.flies ? ', flies' : ''}`);
    this.dot.show(robot.type, robot.flies);
    mark(this.shape, 'data-is', state);
    say(this.state, state);
    say(this.why, whyWords(robot, state, this.app.model, now));
    this.#renderGoal(robot, now);
    this.#renderBattery(robot);
    this.#renderButtons(robot);
    this.#renderFacts(robot, now);
  }

  #renderGoal(robot, now) {
    const { goal } = robot;
    const left = robot.distanceRemaining(now);
    const way = left > 0 ? ` · ${lengthWords(left, this.app.model.world.units)} left` : '';
    say(this.goal, goal ? taskWords(goal, this.app.model.world) + way : 'no goal');
    mark(this.goal, 'data-none', String(!goal));
  }

  #renderBattery({ battery }) {
    this.battery.hidden = !battery;
    if (!battery) return;
    const share = battery.percentage;
    this.meter.firstChild.style.width = `${share * 100}%`;
    mark(this.meter, 'aria-valuenow', String(Math.round(share * 100)));
    mark(this.meter, 'data-level', share < 0.1 ? 'critical' : share < 0.25 ? 'low' : 'good');
    say(this.charge, `${shareWords(share)}${battery.charging ? ', charging' : ''}`);
  }

  #renderButtons(robot) {
    const may = (action) => robot.actions.length === 0 || robot.actions.includes(action);
    const gone = !this.app.commanding;
    this.go.disabled = gone || !may('navigate_to_pose');
    this.dock.disabled = gone || !may('dock_robot') && !robot.dock;
    this.dock.hidden = this.app.model.docks.size === 0;
    say(this.dock.lastChild, robot.dock ? 'Undock' : 'Dock');
    this.act.disabled = gone || robot.actions.length === 0;
    this.cancel.disabled = gone || robot.goals.length === 0;
    this.fault.disabled = gone;
    mark(this.follow, 'aria-pressed', String(this.app.map.follow === robot.name));
  }

  #renderFacts(robot, now) {
    const { model } = this.app;
    const [x, y, yaw] = robot.poseAt(now);
    const waiting = [...model.robots.values()].filter((other) => other.heldBy(model).includes(robot.name));
    const behind = robot.goals.filter((goal) => goal !== robot.goal);
    this.facts.show([
      ['Position', `${x.toFixed(1)}, ${y.toFixed(1)} · ${Math.round((yaw * 180) / Math.PI)}°`],
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
