// The log of what happens, newest first.

import { levelOf, robotsOf, subjectOf, words } from '../model/words.js';
import { button, el, icon, mark, say, sign } from './dom.js';
import { clockWords } from './phrases.js';
import { Rows } from './rows.js';

const ROW = 32;
/** What belongs together for whoever looks for something. */
const GROUPS = {
  'All kinds': null,
  Goals: /^(goal|status|rejected|script_ended|plan_wanted|planner)$/,
  Traffic: /^(waiting|went_on|rerouted|deadlock|made_room|lane_|stopped)/,
  'Faults and errors': null,
  'Batteries and docks': /^(battery_|charging_|dock_)/,
  'Doors and lifts': /^(door_|lift_)/,
  Items: /^(picked|placed|dropped)/,
  Simulation: /^(simulation_state|reset|spawned|deleted|teleported|world_loaded|participant_)/,
};
const BAD = new Set(['warning', 'error']);

export class EventsPanel {
  /** @param {import('../app.js').App} app */
  constructor(app) {
    this.app = app;
    this.title = 'Events';
    /** @type {object[]|null} What was known when it was paused. */
    this.held = null;
    /** What an event is found by. */
    this.lines = new WeakMap();
    const again = () => this.render();
    this.filter = el('input', {
      type: 'search', class: 'field', placeholder: 'Robot, door, place, words', 'aria-label': 'Filter events', oninput: again,
    });
    this.kind = el('select', { class: 'field', 'aria-label': 'Kind of events', onchange: again },
      ...Object.keys(GROUPS).map((name) => el('option', { text: name })));
    this.hold = button('pause', 'Hold the list', () => this.#toggle(), { class: 'quiet' });
    this.rows = new Rows({ label: 'Events', height: ROW, make: () => this.#row() });
    this.empty = el('p', { class: 'empty' });
    this.element = el('div', { class: 'panel-body' },
      el('div', { class: 'tools line' }, this.filter, this.kind, this.hold), this.empty, this.rows.element);
  }

  #toggle() {
    this.held = this.held ? null : this.app.model.events.slice();
    const label = this.held ? 'Go on' : 'Hold the list';
    this.hold.replaceChildren(icon(this.held ? 'play' : 'pause'));
    mark(this.hold, 'aria-label', label);
    mark(this.hold, 'title', label);
    mark(this.hold, 'aria-pressed', String(this.held !== null));
    this.render();
  }

  render() {
    const { model } = this.app;
    const text = this.filter.value.trim().toLowerCase();
    const group = GROUPS[this.kind.value];
    const bad = this.kind.value === 'Faults and errors';
    const shown = [];
    const all = this.held ?? model.events;
    for (let i = all.length - 1; i >= 0; i -= 1) {
      const event = all[i];
      if (group && !group.test(event.kind)) continue;
      if (bad && !BAD.has(levelOf(event)) && !event.kind.startsWith('fault_')) continue;
      if (text && !this.#line(event).includes(text)) continue;
      shown.push(event);
    }
    say(this.empty, shown.length ? '' : all.length ? 'No event is like that.' : 'Nothing has happened yet.');
    this.empty.hidden = shown.length > 0;
    this.rows.element.hidden = shown.length === 0;
    this.rows.show(shown);
  }

  #line(event) {
    let line = this.lines.get(event);
    if (line === undefined) {
      line = `${subjectOf(event)} ${event.kind} ${words(event, this.app.model.world)}`.toLowerCase();
      this.lines.set(event, line);
    }
    return line;
  }

  #row() {
    const parts = {
      time: el('span', { class: 'when' }),
      shape: sign('level', ''),
      who: el('b', { class: 'name' }),
      what: el('span', { class: 'what' }),
    };
    let event = null;
    const press = el('button', { type: 'button', class: 'event', onclick: () => this.#show(event) },
      parts.time, parts.shape, parts.who, parts.what);
    const row = el('div', {}, press);
    row.fill = (given) => {
      if (given === event) return;
      event = given;
      const said = words(event, this.app.model.world);
      say(parts.time, clockWords(event.t, 1));
      mark(parts.shape, 'data-is', levelOf(event));
      say(parts.who, subjectOf(event));
      say(parts.what, said);
      mark(press, 'title', `${subjectOf(event)} ${said}`.trim());
    };
    return row;
  }

  #show(event) {
    const [robot] = robotsOf(event);
    if (robot && this.app.model.robots.has(robot)) this.app.select(robot, { center: true });
    else this.app.centerOn(event.door ?? event.lift ?? event.dock ?? event.entity ?? event.lane?.[0]);
    this.app.playback?.seek(event.t);
  }
}
