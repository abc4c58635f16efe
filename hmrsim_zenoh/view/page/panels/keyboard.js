// Keyboard shortcuts, and the overlay that lists them.

import { button, el } from './dom.js';

/** @type {[string[], string, (app: import('../app.js').App) => void][]} */
const KEYS = [
  [[' '], 'Pause or resume', (app) => app.time.toggle()],
  [['.'], 'Step, while paused', (app) => app.time.stepOnce()],
  [[','], 'Back by 5 seconds', (app) => app.time.back()],
  [['[', ']'], 'Previous, next mark', (app, key) => app.time.jump(key === ']' ? 1 : -1)],
  [['/'], 'Find a robot or place', (app) => app.search.focus()],
  [['a'], 'Send the selected robot any goal', (app) => app.commanding && app.map.selected && app.orders.fillInGoal(app.map.selected)],
  [['m'], 'Send the selected robot to the next click or search', (app) => app.map.selected && app.aim(app.map.selected)],
  [['shift enter'], 'In the search: send the robot to what is found', () => {}],
  [['f'], 'Follow the selected robot, or stop following', (app) => app.map.selected && app.follow(app.map.selected)],
  [['n', 'N'], 'Select the next or the previous robot', (app, key) => app.selectNext(key === 'n' ? 1 : -1)],
  [['ContextMenu'], 'Menu of the selected robot', (app) => app.openMenuOfSelected()],
  [['r', 'g', 'o', 'e', 't', 'c'], 'Robots, goals, orders, events, trees, charts', (app, key) => app.panels.toggle(PANELS[key])],
  [['l'], 'Legend and layers', (app) => app.legend.toggle()],
  [['0'], 'Show all of the map', (app) => app.fit()],
  [['+', '-'], 'Zoom in, zoom out', (app, key) => app.zoom(key === '-' ? 1 / 1.35 : 1.35)],
  [['ArrowLeft', 'ArrowRight', 'ArrowUp', 'ArrowDown'], 'Move the map', (app, key) => app.pan(...WAYS[key])],
  [['d'], 'Dark or light', (app) => app.theme.toggle()],
  [['Escape'], 'Cancel aiming, return to the present, stop following, deselect', (app) => app.escape()],
  [['?'], 'Show the keyboard shortcuts', (app) => app.keyboard.help()],
];
const PANELS = { r: 'robots', g: 'goals', o: 'orders', e: 'events', t: 'trees', c: 'charts' };
const STEP = 90; // css pixels
const WAYS = { ArrowLeft: [STEP, 0], ArrowRight: [-STEP, 0], ArrowUp: [0, STEP], ArrowDown: [0, -STEP] };
const SHOWN = {
  ' ': 'space', Escape: 'esc', ContextMenu: '≣ menu', ArrowLeft: '←', ArrowRight: '→', ArrowUp: '↑', ArrowDown: '↓', N: 'shift n',
};

export class Keyboard {
  constructor(app) {
    this.app = app;
    this.actions = new Map(KEYS.flatMap(([keys, , action]) => keys.map((key) => [key, action])));
    this.actions.set('=', this.actions.get('+'));
    this.element = this.#overlay();
    addEventListener('keydown', (event) => this.#press(event));
    // Or the button with the focus would be pressed, too.
    addEventListener('keyup', (event) => event.key === ' ' && this.#applies(event) && event.preventDefault());
  }

  #overlay() {
    const rows = KEYS.map(([keys, words]) => el('div', {},
      el('dt', {}, ...keys.map((key) => el('kbd', { text: SHOWN[key] ?? key }))), el('dd', { text: words })));
    const close = button('close', 'Close', () => this.element.close(), { class: 'quiet corner' });
    return el('dialog', { class: 'dialog', 'aria-labelledby': 'keys-title' }, close,
      el('h2', { id: 'keys-title', text: 'Keyboard shortcuts' }), el('dl', { class: 'keys' }, ...rows),
      el('p', { class: 'note', text: 'Click a robot, then its goal. A right click or a long press opens a menu. Drag to move the map, scroll or pinch to zoom.' }));
  }

  help() {
    if (this.element.open) this.element.close();
    else this.element.showModal();
  }

  /** Return whether a key is for the page, not for a text that is typed, a choice, a menu or a dialog. */
  #applies({ key, target, ctrlKey, metaKey, altKey }) {
    if (ctrlKey || metaKey || altKey || document.querySelector('dialog[open]') || target.closest?.('[role=menu]')) return false;
    if (key === 'Escape') return true;
    return !target.closest?.('input:not([type=checkbox], [type=range]), textarea') && (key === ' ' || !target.closest?.('select'));
  }

  #press(event) {
    if (!this.#applies(event)) return;
    const { target } = event;
    // Arrows scroll lists and move sliders.
    if (event.key.startsWith('Arrow') && target.closest?.('.rows, .scroll, [type=range]')) return;
    const action = this.actions.get(event.key);
    if (!action) return;
    event.preventDefault();
    if (event.key === 'Escape') target.blur?.();
    action(this.app, event.key);
  }
}
