// The context menu of an object on the map: right click, long press or menu key.

import { pointWords } from '../model/phrases.js';
import { el, icon } from './dom.js';

export class Menu {
  constructor(app) {
    this.app = app;
    this.element = el('div', { class: 'menu', role: 'menu', hidden: true, onkeydown: (event) => this.#key(event) });
    addEventListener('pointerdown', ({ target }) => this.element.contains(target) || this.close(), true);
    addEventListener('resize', () => this.close());
    addEventListener('blur', () => this.close());
  }

  open(pick) {
    const title = pick.name && pick.kind !== 'floor' ? pick.name.replace('|', ' – ') : pointWords(pick.point, this.app.model.world.units);
    this.before = document.activeElement;
    this.element.replaceChildren(el('div', { class: 'menu-title', text: title, role: 'presentation' }),
      ...this.#entries(pick).map((entry) => (entry ? this.#item(entry) : el('hr', { role: 'separator' }))));
    this.element.hidden = false;
    const { offsetWidth: width, offsetHeight: height, style } = this.element;
    style.left = `${Math.max(8, Math.min(pick.px, innerWidth - width - 8))}px`;
    style.top = `${Math.max(8, Math.min(pick.py, innerHeight - height - 8))}px`;
    this.#items()[0]?.focus({ preventScroll: true });
  }

  close() {
    if (this.element.hidden) return;
    const inside = this.element.contains(document.activeElement);
    this.element.hidden = true;
    if (inside) this.before?.focus?.({ preventScroll: true });
  }

  #item([picture, text, action]) {
    const onclick = () => (this.close(), action());
    return el('button', { type: 'button', role: 'menuitem', class: 'menu-item', tabindex: '-1', onclick }, icon(picture), el('span', { text }));
  }

  #items() { return [...this.element.querySelectorAll('[role=menuitem]')]; }

  #key(event) {
    const items = this.#items();
    const at = items.indexOf(document.activeElement);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1 + items.length, Home: 0, End: items.length - 1 }[event.key];
    const presses = ['Enter', ' '].includes(event.key);
    if (to !== undefined) items[to % items.length].focus();
    else if (event.key === 'Escape' || event.key === 'Tab') this.close();
    else if (!presses) return;
    event.stopPropagation();
    if (!presses) event.preventDefault();
  }

  /** Return the entries, each [icon, text, action], or null for a separator. */
  #entries(pick) {
    const own = ENTRIES[pick.kind]?.(this.app, pick.name) ?? [];
    const all = [...this.#send(pick), ...own.filter((entry) => this.app.commanding || !entry || entry[3]),
      ['target', 'Center here', () => this.app.map.camera.centerOn(...pick.point)]];
    return all.filter((entry, i) => entry || (i && all[i - 1] && i < all.length - 1));
  }

  #send(pick) {
    const { commanding, map: { selected: robot }, orders } = this.app;
    if (!commanding || !robot || (pick.kind === 'robot' && pick.name === robot)) return [];
    const here = ['target', `Send ${robot} here`, () => orders.sendToPoint(robot, pick)];
    return pick.kind === 'dock' ? [['dock', `Dock ${robot} here`, () => orders.sendToDock(robot, pick.name)], here, null] : [here, null];
  }
}

const READS = true; // also available in recordings

const ENTRIES = {
  robot(app, name) {
    const { model, orders, map } = app;
    const robot = model.robots.get(name);
    if (!robot) return [];
    const dock = robot.dock ? ['dock', 'Undock', () => orders.undock(name)] : ['dock', 'Dock', () => orders.sendToDock(name)];
    const cancel = ['stop', 'Cancel goal', () => orders.cancelAll(name)];
    return [
      ['robot', 'Select', () => app.select(name), READS],
      ['follow', map.follow === name ? 'Stop following' : 'Follow', () => app.follow(name), READS],
      null,
      ['target', 'Go to…', () => app.aim(name)],
      ...(model.docks.size ? [dock] : []),
      ['goals', 'Send goal…', () => orders.fillInGoal(name)],
      ...(robot.goals.length ? [cancel] : []),
      null,
      ...faultEntries(app, { robot: name }, [['Break down', { type: 'breakdown' }], ['Slip at half speed', { type: 'slip', factor: 0.5 }]]),
      null,
    ];
  },
  door(app, name) {
    const set = (state, words) => ['door', words, () => app.orders.call(`${words.toLowerCase()} door ${name}`, 'set_door_state', { name, state })];
    return [set('open', 'Open'), set('closed', 'Close'), set('locked', 'Lock'), null,
      ...faultEntries(app, { door: name }, [['Jam', { type: 'door_jammed' }]]), null];
  },
  lift({ model, orders }, name) {
    const stops = model.lifts.get(name)?.stops ?? [];
    return [...stops.map((stop) => ['door', `Call to ${stop}`, () => orders.call(`call ${name}`, 'call_lift', { name, stop })]), null];
  },
  item({ model, map, orders }, name) {
    const robot = model.robots.get(map.selected);
    if (!robot?.actions.includes('pickup')) return [];
    return [['item', `Pick up with ${robot.name}`, () => orders.fillInGoal(robot.name, 'pickup', { target_name: name })], null];
  },
  lane: (app, key) => [...faultEntries(app, { lane: key.split('|') }, [['Close this lane', { type: 'lane_closed' }]]), null],
};

/** Return the entries to inject and to clear faults of an object. */
function faultEntries({ model, orders }, target, quick) {
  const on = [...model.faults.values()].filter((fault) => concerns(fault, target));
  const there = new Set(on.map(({ fault }) => fault));
  return [
    ...on.map(({ name }) => ['check', `Clear ${name}`, () => orders.call(`clear ${name}`, 'clear_fault', { name })]),
    ...quick.filter(([, { type }]) => !there.has(type)).map(([words, fault]) => ['fault', words, () => orders.inject({ ...fault, ...target })]),
    ['fault', 'Inject fault…', () => orders.fillInFault(target)],
  ];
}

function concerns(fault, { robot, door, lane }) {
  if (lane) return fault.lane !== undefined && lane.every((end) => fault.lane.includes(end));
  return robot !== undefined ? fault.robot === robot : fault.door === door;
}
