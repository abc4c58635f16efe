// Short messages of what was done, or was refused and why.

import { button, el } from './dom.js';

const MAX_TOASTS = 4;
const LASTS = { info: 3500, good: 3500, error: 9000 }; // ms

export class Toasts {
  element = el('div', { class: 'toasts', role: 'log', 'aria-live': 'polite', 'aria-label': 'Messages' });

  /** @param {'info'|'good'|'error'} kind @param {string} text @param {string} [more] */
  show(kind, text, more = '') {
    const toast = el('div', { class: 'toast', data: { kind }, role: kind === 'error' ? 'alert' : null },
      el('div', {}, el('span', { text }), more ? el('small', { text: more }) : null),
      button('close', 'Dismiss', () => toast.remove(), { class: 'quiet small' }));
    this.element.append(toast);
    while (this.element.children.length > MAX_TOASTS) this.element.firstChild.remove();
    setTimeout(() => toast.remove(), LASTS[kind]);
  }
}
