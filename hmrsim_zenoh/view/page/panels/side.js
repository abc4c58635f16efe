// The side of the page where one panel at a time is open; on a phone a sheet at the bottom.

import { button, el, mark, say } from './dom.js';

export class Side {
  /**
   * @param {import('../app.js').App} app
   * @param {Record<string, {title: string, element: HTMLElement, render: () => void, seen?: (seen: boolean) => void}>} panels
   */
  constructor(app, panels) {
    this.app = app;
    this.panels = panels;
    /** @type {string|null} */
    this.open = null;
    this.title = el('h2', { id: 'side-title' });
    this.body = el('div', { class: 'side-body' });
    this.element = el('aside', { class: 'side', 'aria-labelledby': 'side-title', hidden: true },
      el('header', {}, el('span', { class: 'grip', 'aria-hidden': 'true' }), this.title,
        button('close', 'Close', () => this.show(null), { key: 'esc', class: 'quiet' })), this.body);
    this.buttons = new Map(Object.entries(panels).map(([name, { title }]) =>
      [name, button(name, title, () => this.toggle(name), { key: name[0], text: true, class: 'tab' })]));
    this.tabs = el('div', { class: 'tabs', role: 'group', 'aria-label': 'Panels' }, ...this.buttons.values());
  }

  toggle(name) {
    this.show(this.open === name ? null : name);
  }

  /** @param {string|null} name */
  show(name) {
    const next = this.panels[name] ? name : null;
    if (next === this.open) return;
    this.panels[this.open]?.seen?.(false);
    this.open = next;
    for (const [each, tab] of this.buttons) mark(tab, 'aria-expanded', String(each === next));
    this.element.hidden = next === null;
    mark(document.body, 'data-panel', next ?? 'none');
    if (next !== null) {
      say(this.title, this.panels[next].title);
      this.body.replaceChildren(this.panels[next].element);
      this.panels[next].seen?.(true);
    }
    this.app.layout();
    this.render();
  }

  render() {
    if (this.open !== null) this.panels[this.open].render();
  }
}
