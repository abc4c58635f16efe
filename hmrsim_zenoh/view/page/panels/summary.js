// Which world it is, and how many robots are in which state.

import { STATES } from '../model/robot.js';
import { el, mark, say, sign } from './dom.js';

export class Summary {
  /** @param {import('../app.js').App} app */
  constructor(app) {
    this.app = app;
    this.world = el('h1', { text: 'hmrsim' });
    this.counts = new Map();
    const list = el('ul', { class: 'counts', 'aria-label': 'Robots by state' });
    for (const state of STATES) {
      const count = el('span');
      const item = el('li', { title: state }, sign('state', state), count, el('span', { class: 'unseen', text: state }));
      this.counts.set(state, { count, item });
      list.append(item);
    }
    this.element = el('div', { class: 'summary' }, this.world, list);
  }

  render() {
    const { model, playback } = this.app;
    const name = playback?.name ? `${model.world.name} · ${playback.name}` : model.world.name;
    say(this.world, name);
    if (document.title !== `${name} · hmrsim`) document.title = `${name} · hmrsim`;
    const now = this.app.now();
    const counts = new Map();
    for (const robot of model.robots.values()) {
      const state = robot.stateAt(now);
      counts.set(state, (counts.get(state) ?? 0) + 1);
    }
    for (const [state, { count, item }] of this.counts) {
      const number = counts.get(state) ?? 0;
      say(count, String(number));
      item.hidden = number === 0;
      mark(item, 'title', `${number} ${state}`);
    }
  }
}
