// Dark or light, as asked for, chosen before or set for all pages; and the colours that the page shares with the map.

import { button, icon } from './dom.js';

const DARK = matchMedia('(prefers-color-scheme: dark)');
const KEY = 'hmrsim.theme';

export class Theme {
  /** @param {import('../app.js').App} app */
  constructor(app) {
    this.app = app;
    /** @type {'dark'|'light'} */
    this.name = 'light';
    this.button = button('sun', 'Dark or light', () => this.toggle(), { key: 'd' });
    for (const [state, colour] of Object.entries(app.palette.states)) {
      document.documentElement.style.setProperty(`--${state}`, colour);
    }
    DARK.addEventListener('change', () => this.begin());
  }

  begin() {
    this.set(this.app.asked.get('theme') ?? remembered() ?? (DARK.matches ? 'dark' : 'light'));
  }

  toggle() {
    this.set(this.name === 'dark' ? 'light' : 'dark');
    try {
      localStorage.setItem(KEY, this.name);
    } catch {
      // Then it is chosen anew next time.
    }
  }

  set(name) {
    this.name = name === 'dark' ? 'dark' : 'light';
    document.documentElement.dataset.theme = this.name;
    this.app.map.theme = this.name;
    this.button.replaceChildren(icon(this.name === 'dark' ? 'sun' : 'moon'));
    this.app.legend.render();
    this.app.render();
  }
}

function remembered() {
  try {
    return localStorage.getItem(KEY);
  } catch {
    return null; // forbidden by the browser's settings
  }
}
