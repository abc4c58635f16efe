// The live table of goals: newest first, filtered by text and state.

import { isActive } from '../model/goals.js';
import { STATUS_WORDS, feedbackWords, lastingWords, lengthWords, taskWords } from '../model/phrases.js';
import { ListPanel, button, el, mark, say, taskRow } from './dom.js';

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
    this.shown = 'all';
    this.chips = Object.keys(SHOWN).map((word) => {
      const count = el('span', { class: 'count' });
      return { word, count, chip: el('button', { type: 'button', class: 'chip', onclick: () => this.#show(word) }, word, count) };
    });
    this.place(el('div', { class: 'tools' }, this.filter,
      el('div', { class: 'chips', role: 'group', 'aria-label': 'Which goals' }, ...this.chips.map(({ chip }) => chip))));
  }

  #show(word) {
    this.shown = word;
    this.toTop();
    this.render();
  }

  render() {
    const all = [...this.app.model.goals.values()].reverse();
    const asked = this.matching(all, (goal) => this.#words(goal));
    for (const { word, chip, count } of this.chips) {
      say(count, asked.filter(SHOWN[word]).length);
      mark(chip, 'aria-pressed', word === this.shown);
    }
    const none = this.app.live ? 'No goals yet. Click a robot, then its goal.' : 'No goals yet.';
    this.showItems(asked.filter(SHOWN[this.shown]), all.length ? 'No goal matches.' : none);
  }

  #words(goal) {
    const { robot, action, status, errorMsg } = goal;
    return `${robot} ${action} ${taskWords(goal, this.app.model.world)} ${STATUS_WORDS[status]} ${errorMsg}`;
  }

  row() {
    const { app } = this;
    const long = el('span', { class: 'long' });
    const cancel = button('close', 'Cancel this goal', (event) => {
      event.stopPropagation();
      const goal = row.item;
      app.orders.ask(`cancel ${goal.action} of ${goal.robot}`, () => app.commands.cancel(goal));
    }, { class: 'quiet small' });
    const end = el('div', { class: 'goal-end', role: 'cell' }, long, cancel);
    const row = taskRow(() => app.select(row.item.robot, { center: true }), ['task', '', 'detail'], end);
    Object.assign(row.parts, { long, cancel });
    return row;
  }

  fill(row, goal) {
    const { app, app: { map, model } } = this;
    const { shape, name, task, status, detail, main, long, cancel } = row.parts;
    const word = STATUS_WORDS[goal.status] ?? 'unknown';
    const asked = taskWords(goal, model.world);
    const more = isActive(goal.status) ? this.#progress(goal) : errorWords(goal, model.world);
    mark(shape, 'data-is', word);
    say(name, goal.robot === '_world' ? 'world' : goal.robot);
    say(task, asked);
    say(status, word);
    // The sign shows the status, so that there is room for the detail.
    mark(status, 'class', more ? 'unseen' : 'word');
    say(detail, more);
    mark(main, 'title', [asked, word, more].filter(Boolean).join('\n'));
    mark(detail, 'data-error', goal.status === 6);
    mark(row, 'data-selected', goal.robot === map.selected);
    say(long, goal.accepted === null ? '' : lastingWords(Math.max(0, (goal.ended ?? app.now()) - goal.accepted)));
    cancel.hidden = !isActive(goal.status) || !app.commanding;
  }

  #progress(goal) {
    const { robots, world: { units } } = this.app.model;
    const robot = robots.get(goal.robot);
    const said = feedbackWords(goal.feedback, units);
    if (said || robot?.goal?.key !== goal.key) return said;
    if (robot.waiting) return robot.waiting.for.length ? `waiting for ${robot.waiting.for.join(' and ')}` : robot.waiting.why;
    const left = robot.distanceRemaining(this.app.now());
    return left > 0 ? `${lengthWords(left, units)} left` : '';
  }
}

function errorWords({ status, errorCode, errorMsg }, world) {
  if (errorMsg === STATUS_WORDS[status]) return ''; // A canceled goal has the text "canceled".
  const text = errorMsg.replaceAll(/\b([0-9a-f]{8})[0-9a-f]{24}\b/g, '$1…'); // ids of goals
  return [world.withNames(text), errorCode === null ? '' : `code ${errorCode}`].filter(Boolean).join(' · ');
}
