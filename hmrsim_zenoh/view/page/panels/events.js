// The log of events, newest first.

import { describe } from '../model/texts.js';
import { ListPanel, button, el, mark, say, showPlayButton, sign } from './dom.js';
import { clockWords, inWords } from '../model/phrases.js';

const ALL = 'All kinds';
const BAD = 'Warnings and errors';

export class EventsPanel extends ListPanel {
  constructor(app) {
    super(app, 'Events', 'Robot, door, place, words', { height: 32 });
    this.held = null; // the events at the time of pausing
    this.descriptions = new WeakMap(); // the description of each event, with the text to search
    this.kind = el('select', { class: 'field', 'aria-label': 'Kind of events', onchange: () => this.changed() });
    app.model.addEventListener('world', () => this.#groups());
    this.#groups();
    this.hold = button('pause', 'Pause the list', () => this.#toggle(), { class: 'quiet' });
    this.place(el('div', { class: 'tools line' }, this.filter, this.kind, this.hold));
  }

  #toggle() {
    this.held = this.held ? null : this.app.model.events.slice();
    showPlayButton(this.hold, !this.held, this.held ? 'Resume the list' : 'Pause the list', '');
    mark(this.hold, 'aria-pressed', this.held !== null);
    this.render();
  }

  render() {
    const { value: kind } = this.kind;
    const all = this.held ?? this.app.model.events;
    const ofKind = (event) => {
      const { severity, group } = this.#describe(event);
      return kind === BAD ? ['warning', 'error'].includes(severity) : group === kind;
    };
    const found = this.matching(kind === ALL ? all : all.filter(ofKind), (event) => this.#describe(event).line);
    this.showItems([...found].reverse(), all.length ? 'No event matches.' : 'No events yet.');
  }

  #groups() {
    const groups = [...new Set(Object.values(this.app.model.texts).map(({ group }) => group))].sort();
    if (this.kind.options.length === groups.length + 2) return;
    this.kind.replaceChildren(...[ALL, BAD].map((name) => el('option', { text: name })),
      ...groups.map((name) => el('option', { value: name, text: inWords(name) })));
  }

  #describe(event) {
    let description = this.descriptions.get(event);
    if (description === undefined) {
      description = describe(event, this.app.model);
      description.line = `${description.subject} ${event.kind} ${description.text}`;
      this.descriptions.set(event, description);
    }
    return description;
  }

  row() {
    const [time, shape, who, what] = [el('span', { class: 'when' }), sign('level', ''), el('b', { class: 'name' }), el('span', { class: 'what' })];
    const press = el('button', { type: 'button', class: 'event', onclick: () => this.#show(row.item) }, time, shape, who, what);
    const row = Object.assign(el('div', {}, press), { parts: { time, shape, who, what, press } });
    return row;
  }

  fill({ parts: { time, shape, who, what, press } }, event) {
    const { severity, subject, text } = this.#describe(event);
    say(time, clockWords(event.t, 1));
    mark(shape, 'data-is', severity);
    say(who, subject);
    say(what, text);
    mark(press, 'title', `${subject} ${text}`.trim());
  }

  /** Select the first robot that an event names, or else center on the first named object. */
  #show(event) {
    const { kind: _, ...fields } = event;
    const named = Object.values(fields).flat().filter((value) => typeof value === 'string');
    this.app.show(named);
    if (this.app.live?.rewind.active) this.app.live.rewind.seek(event.t);
    else this.app.playback?.seek(event.t);
  }
}
