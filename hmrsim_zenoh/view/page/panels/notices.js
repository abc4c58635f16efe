// Messages to people: the banner about a lost connection, hints, and toasts.

import { lastingWords } from '../model/phrases.js';
import { button, el, mark, recall, remember, say } from './dom.js';

const TEXTS = {
  connecting: 'Connecting to the simulator…',
  lost: 'Lost the connection to the simulator. Reconnecting…',
  'no server': 'Lost the connection to the server of this page. Reconnecting…',
};
const PATIENCE = 600; // ms before the banner appears

export class Banner {
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
    if (state === 'live' && this.missed) this.app.toasts.show('good', 'Reconnected to the simulator.');
    if (state === 'live') this.missed = false;
    else if (!this.missed) this.began = performance.now();
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
    say(this.text, TEXTS[this.missed && state === 'connecting' ? 'lost' : state]);
    say(this.since, `for ${lastingWords(Math.floor(lasted / 1000)).replace('.0', '')}`);
  }
}

const KEY = 'hmrsim.welcomed';
const WIDE = 1500; // css pixels of width that leave room for a longer hint

export class Hint {
  constructor(app) {
    this.app = app;
    this.text = el('span', { role: 'status', 'aria-live': 'polite' });
    this.key = el('button', { type: 'button', class: 'kbd', onclick: () => app.escape() });
    this.close = button('close', 'Got it', () => this.known(), { class: 'quiet small' });
    this.element = el('div', { class: 'hint', hidden: true }, this.text, this.key, this.close);
    this.welcomes = false;
  }

  /** Show a hint, or none for "". @param {number} [lasts] Milliseconds; 0 for until the next hint. @param {string} [key] Ends it. */
  show(text, lasts = 0, key = '') {
    clearTimeout(this.timer);
    say(this.text, text);
    say(this.key, key);
    this.key.hidden = key === '';
    this.close.hidden = true;
    this.element.hidden = text === '';
    if (lasts) this.timer = setTimeout(() => (this.element.hidden = true), lasts);
  }

  /** Show how to begin, once in each browser. */
  welcome() {
    if (!this.app.live || recall(KEY) !== null) return;
    const touch = matchMedia('(pointer: coarse)').matches;
    const more = touch ? ' Hold for more.' : innerWidth > WIDE ? ' Right click for more.' : '';
    this.show(`${touch ? 'Tap' : 'Click'} a robot, then its goal.${more}`);
    this.welcomes = true;
    this.close.hidden = false;
  }

  /** Hide the welcome after a click. */
  known() {
    if (!this.welcomes) return;
    this.welcomes = false;
    if (!this.close.hidden) this.show('');
    remember(KEY, 'true');
  }
}

const MAX_TOASTS = 4;
const LASTS = { info: 3500, good: 3500, error: 9000 }; // ms

export class Toasts {
  element = el('div', { class: 'toasts', role: 'log', 'aria-live': 'polite', 'aria-label': 'Messages' });

  show(kind, text, more = '') {
    const toast = el('div', { class: 'toast', data: { kind }, role: kind === 'error' ? 'alert' : null },
      el('div', {}, el('span', { text }), more ? el('small', { text: more }) : null),
      button('close', 'Dismiss', () => toast.remove(), { class: 'quiet small' }));
    this.element.append(toast);
    while (this.element.children.length > MAX_TOASTS) this.element.firstChild.remove();
    setTimeout(() => toast.remove(), LASTS[kind]);
  }
}
