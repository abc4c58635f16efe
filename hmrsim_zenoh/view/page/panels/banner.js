// Says when the simulator, or the page's own server, is not there, since when, and when it is back.

import { el, mark, say } from './dom.js';
import { lastingWords } from './phrases.js';

const TEXTS = {
  connecting: 'Connecting to the simulator…',
  lost: 'Lost the connection to the simulator. Reconnecting…',
  'no server': 'Lost the connection to the server of this page. Reconnecting…',
};
const PATIENCE = 600; // ms for which nothing is said

export class Banner {
  /** @param {import('../app.js').App} app */
  constructor(app) {
    this.app = app;
    this.text = el('span', { role: 'status', 'aria-live': 'assertive' });
    this.since = el('small', { 'aria-hidden': 'true' });
    this.element = el('div', { class: 'banner', hidden: true }, el('span', { class: 'spinner', 'aria-hidden': 'true' }), this.text, this.since);
    this.began = performance.now();
    this.missed = false;
    app.live?.addEventListener('state', () => this.#changed());
  }

  #changed() {
    const { state } = this.app.live;
    if (state === 'live') {
      if (this.missed) this.app.toasts.show('good', 'Reconnected to the simulator.');
      this.missed = false;
    } else if (!this.missed) {
      this.began = performance.now();
    }
    if (state === 'lost' || state === 'no server') this.missed = this.app.shown;
    this.render();
  }

  render() {
    if (!this.app.live || !this.app.shown) return;
    const { state } = this.app.live;
    const lasted = performance.now() - this.began;
    this.element.hidden = state === 'live' || (state === 'connecting' && lasted < PATIENCE);
    if (this.element.hidden) return;
    mark(this.element, 'data-state', state);
    say(this.text, this.missed && state === 'connecting' ? TEXTS.lost : TEXTS[state]);
    say(this.since, `for ${lastingWords(Math.floor(lasted / 1000)).replace('.0', '')}`);
  }
}
