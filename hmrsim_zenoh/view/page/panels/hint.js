// A line above the bar of time: what the next click does, and in the beginning how to begin.

import { button, el, say } from './dom.js';

const KEY = 'hmrsim.welcomed';
const WIDE = 1500; // css pixels that leave room for more

export class Hint {
  /** @param {import('../app.js').App} app */
  constructor(app) {
    this.app = app;
    this.text = el('span', { role: 'status', 'aria-live': 'polite' });
    this.key = el('button', { type: 'button', class: 'kbd', onclick: () => app.escape() });
    this.close = button('close', 'Got it', () => this.known(), { class: 'quiet small' });
    this.element = el('div', { class: 'hint', hidden: true }, this.text, this.key, this.close);
    this.welcomes = false;
  }

  /** @param {string} text "": none. @param {number} [lasts] Milliseconds; 0: until another comes. @param {string} [key] That ends it. */
  show(text, lasts = 0, key = '') {
    clearTimeout(this.timer);
    say(this.text, text);
    say(this.key, key);
    this.key.hidden = key === '';
    this.close.hidden = true;
    this.element.hidden = text === '';
    if (lasts) this.timer = setTimeout(() => (this.element.hidden = true), lasts);
  }

  /** Say how to begin, once in each browser. */
  welcome() {
    try {
      if (!this.app.live || localStorage.getItem(KEY)) return;
    } catch {
      return;
    }
    this.welcomes = true;
    const touch = matchMedia('(pointer: coarse)').matches;
    const more = touch ? ' Hold for more.' : innerWidth > WIDE ? ' Right click for more.' : '';
    this.show(`${touch ? 'Tap' : 'Click'} a robot, then its goal.${more}`);
    this.close.hidden = false;
  }

  /** Hide the welcome: a click shows that it is known. */
  known() {
    if (!this.welcomes) return;
    this.welcomes = false;
    this.show('');
    try {
      localStorage.setItem(KEY, 'true');
    } catch {
      // Then it is said again next time.
    }
  }
}
