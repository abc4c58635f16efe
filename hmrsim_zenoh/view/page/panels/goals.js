// The live table of goals: newest first, filtered by text and state.

import { isActive } from '../model/goals.js';
import { ListPanel, button, el, mark, say, sign } from './dom.js';
import { STATUS_WORDS, feedbackWords, lastingWords, lengthWords, taskWords } from '../model/phrases.js';

const SHOWN = {
  all: () => true,
  active: (goal) => isActive(goal.status),
  done: (goal) => goal.status === 4,
  canceled: (goal) => goal.status === 5,
  failed: (goal) => goal.status === 6,
};

export class GoalsPanel extends ListPanel {
  constructor(app) {
    super(app, 'Goals', 'Robot, action, place, error', { height: 64, role: 'table' });
    this.chips = new Map();
    this.shown = 'all';
    this.lines = new WeakMap(); // the text to search for each goal
    const chips = el('div', { class: 'chips', role: 'group', 'aria-label': 'Which goals' });
    for (const word of Object.keys(SHOWN)) chips.append(this.#chip(word));
    this.place(el('div', { class: 'tools' }, this.filter, chips));
  }

  #chip(word) {
    const count = el('span', { class: 'count' });
    const chip = el('button', { type: 'button', class: 'chip', onclick: () => this.#show(word) }, word, count);
    this.chips.set(word, { chip, count });
    return chip;
  }

  #show(word) {
    this.shown = word;
    this.rows.toTop();
    this.render();
  }

  render() {
    const all = [...this.app.model.goals.values()].reverse();
    const { text } = this;
    const asked = text ? all.filter((goal) => this.#line(goal).includes(text)) : all;
    for (const [word, { chip, count }] of this.chips) {
      const number = word === 'all' ? asked.length : asked.filter(SHOWN[word]).length;
      say(count, String(number));
      mark(chip, 'aria-pressed', String(word === this.shown));
    }
    const goals = asked.filter(SHOWN[this.shown]);
    this.rows.show(goals, this.#nothing(all.length));
  }

  #nothing(known) {
    if (known) return 'No goal matches.';
    return this.app.live ? 'No goals yet. Click a robot, then its goal.' : 'No goals yet.';
  }

  #line(goal) {
    const known = this.lines.get(goal);
    if (known !== undefined) return known;
    const { robot, action, status, errorMsg } = goal;
    const line = `${robot} ${action} ${taskWords(goal, this.app.model.world)} ${STATUS_WORDS[status]} ${errorMsg}`.toLowerCase();
    this.lines.set(goal, line);
    return line;
  }

  row() {
    const parts = {
      shape: sign('status', ''),
      robot: el('b', { class: 'name' }),
      task: el('span', { class: 'task' }),
      status: el('span'),
      detail: el('span', { class: 'detail' }),
      long: el('span', { class: 'long' }),
    };
    let goal = null;
    const cancel = button('close', 'Cancel this goal', (event) => {
      event.stopPropagation();
      this.app.orders.ask(`cancel ${goal.action} of ${goal.robot}`, () => this.app.commands.cancel(goal));
    }, { class: 'quiet small' });
    const select = el('button', {
      type: 'button', class: 'goal-name', onclick: () => this.app.select(goal.robot, { center: true }),
    }, parts.robot, parts.task);
    parts.main = el('div', { class: 'goal-main', role: 'cell' }, select,
      el('div', { class: 'goal-how' }, parts.status, parts.detail));
    const row = el('div', { class: 'goal' },
      el('div', { class: 'goal-sign', role: 'cell' }, parts.shape),
      parts.main,
      el('div', { class: 'goal-end', role: 'cell' }, parts.long, cancel));
    row.fill = (given) => {
      goal = given;
      this.#fill(row, parts, goal);
      cancel.hidden = !isActive(goal.status) || !this.app.commanding;
    };
    return row;
  }

  #fill(row, parts, goal) {
    const { model } = this.app;
    const now = this.app.now();
    const word = STATUS_WORDS[goal.status] ?? 'unknown';
    mark(parts.shape, 'data-is', word);
    say(parts.robot, goal.robot === '_world' ? 'world' : goal.robot);
    say(parts.task, taskWords(goal, model.world));
    const detail = isActive(goal.status) ? this.#progress(goal, now) : errorWords(goal, model.world);
    say(parts.status, word);
    // The sign shows the status, so that there is room for the detail.
    mark(parts.status, 'class', detail ? 'unseen' : 'word');
    say(parts.detail, detail);
    mark(parts.main, 'title', [parts.task.textContent, word, detail].filter(Boolean).join('\n'));
    mark(parts.detail, 'data-error', String(goal.status === 6));
    say(parts.long, goal.accepted === null ? '' : lastingWords(Math.max(0, (goal.ended ?? now) - goal.accepted)));
    mark(row, 'data-selected', String(goal.robot === this.app.map.selected));
  }

  #progress(goal, now) {
    const { model } = this.app;
    const robot = model.robots.get(goal.robot);
    const said = feedbackWords(goal.feedback, model.world.units);
    if (said || robot?.goal?.key !== goal.key) return said;
    if (robot.waiting) return robot.waiting.for.length ? `waiting for ${robot.waiting.for.join(' and ')}` : robot.waiting.why;
    const left = robot.distanceRemaining(now);
    return left > 0 ? `${lengthWords(left, model.world.units)} left` : '';
  }
}

function errorWords({ status, errorCode, errorMsg }, world) {
  if (errorMsg === STATUS_WORDS[status]) return ''; // A canceled goal has the text "canceled".
  return [world.withNames(errorMsg), errorCode === null ? '' : `code ${errorCode}`].filter(Boolean).join(' · ');
}
