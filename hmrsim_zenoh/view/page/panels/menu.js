// The context menu of an object on the map: right click, long press or menu key.

import { pointWords } from '../model/phrases.js';
import { el, icon } from './dom.js';

export class Menu {
  constructor(app) {
    this.app = app;
    this.element = el('div', { class: 'menu', role: 'menu', hidden: true, onkeydown: (event) => this.#key(event) });
    addEventListener('pointerdown', (event) => {
      if (!this.element.contains(event.target)) this.close();
    }, true);
    addEventListener('resize', () => this.close());
    addEventListener('blur', () => this.close());
  }

  open(pick) {
    const entries = this.#entries(pick);
    const title = pick.name && pick.kind !== 'floor' ? `${pick.name.replace('|', ' – ')}` : pointWords(pick.point, this.app.model.world.units);
    this.before = document.activeElement;
    this.element.replaceChildren(el('div', { class: 'menu-title', text: title, role: 'presentation' }),
      ...entries.map((entry) => (entry ? this.#item(entry) : el('hr', { role: 'separator' }))));
    this.element.hidden = false;
    const { offsetWidth: width, offsetHeight: height } = this.element;
    const left = Math.max(8, Math.min(pick.px, innerWidth - width - 8));
    const top = Math.max(8, Math.min(pick.py, innerHeight - height - 8));
    this.element.style.left = `${left}px`;
    this.element.style.top = `${top}px`;
    this.#items()[0]?.focus({ preventScroll: true });
  }

  close() {
    if (this.element.hidden) return;
    const inside = this.element.contains(document.activeElement);
    this.element.hidden = true;
    if (inside) this.before?.focus?.({ preventScroll: true });
  }

  #item([picture, text, action]) {
    return el('button', {
      type: 'button', role: 'menuitem', class: 'menu-item', tabindex: '-1',
      onclick: () => {
        this.close();
        action();
      },
    }, icon(picture), el('span', { text }));
  }

  #items() {
    return [...this.element.querySelectorAll('[role=menuitem]')];
  }

  #key(event) {
    const items = this.#items();
    const at = items.indexOf(document.activeElement);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1 + items.length, Home: 0, End: items.length - 1 }[event.key];
    if (to !== undefined) items[to % items.length].focus();
    else if (event.key === 'Escape' || event.key === 'Tab') this.close();
    else if (event.key !== 'Enter' && event.key !== ' ') return;
    event.stopPropagation();
    if (event.key !== 'Enter' && event.key !== ' ') event.preventDefault();
  }

  /** Return the entries, each [icon, text, action], or null for a separator. */
  #entries(pick) {
    const own = ENTRIES[pick.kind]?.(this.app, pick.name) ?? [];
    const all = [...this.#send(pick), ...own.filter((entry) => this.app.commanding || !entry || entry[3]),
      ['target', 'Center here', () => this.app.map.camera.centerOn(...pick.point)]];
    return all.filter((entry, i) => entry || (i && all[i - 1] && i < all.length - 1));
  }

  #send(pick) {
    const { app } = this;
    const robot = app.map.selected;
    if (!app.commanding || !robot || (pick.kind === 'robot' && pick.name === robot)) return [];
    if (pick.kind === 'dock') {
      return [['dock', `Dock ${robot} here`, () => app.orders.sendToDock(robot, pick.name)],
        ['target', `Send ${robot} here`, () => app.orders.sendToPoint(robot, pick)], null];
    }
    return [['target', `Send ${robot} here`, () => app.orders.send(robot, pick)], null];
  }
}

const READS = true; // also available in recordings

const ENTRIES = {
  robot(app, name) {
    const robot = app.model.robots.get(name);
    if (!robot) return [];
    const goals = robot.goals.length ? [['stop', 'Cancel goal', () => app.orders.ask(`cancel the goals of ${name}`, () => app.commands.cancelAll(name))]] : [];
    const dock = robot.dock ? [['dock', 'Undock', () => app.orders.undock(name)]]
      : app.model.docks.size ? [['dock', 'Dock', () => app.orders.sendToDock(name)]] : [];
    return [
      ['robot', 'Select', () => app.select(name), READS],
      ['follow', app.map.follow === name ? 'Stop following' : 'Follow', () => app.follow(name), READS],
      null,
      ['target', 'Go to…', () => app.aim(name)], ...dock, ['goals', 'Send goal…', () => app.orders.fillInGoal(name)], ...goals,
      null,
      ...faultEntries(app, { robot: name }, [['Break down', { type: 'breakdown' }], ['Slip at half speed', { type: 'slip', factor: 0.5 }]]),
      null,
    ];
  },
  door(app, name) {
    const set = (state, words) => ['door', words, () => app.orders.ask(`${words.toLowerCase()} door ${name}`, () => app.commands.setDoor(name, state))];
    return [set('open', 'Open'), set('closed', 'Close'), set('locked', 'Lock'), null,
      ...faultEntries(app, { door: name }, [['Jam', { type: 'door_jammed' }]]), null];
  },
  lift(app, name) {
    const stops = app.model.lifts.get(name)?.stops ?? [];
    return [...stops.map((stop) => ['door', `Call to ${stop}`, () => app.orders.ask(`call ${name}`, () => app.commands.callLift(name, stop))]), null];
  },
  item(app, name) {
    const robot = app.model.robots.get(app.map.selected);
    if (!robot?.actions.includes('pickup')) return [];
    return [['item', `Pick up with ${robot.name}`, () => app.orders.fillInGoal(robot.name, 'pickup', { target_name: name })], null];
  },
  lane(app, key) {
    return [...faultEntries(app, { lane: key.split('|') }, [['Close this lane', { type: 'lane_closed' }]]), null];
  },
};

/** Return the entries to inject and to clear faults of an object. */
function faultEntries(app, target, quick) {
  const on = [...app.model.faults.values()].filter((fault) => concerns(fault, target));
  const there = new Set(on.map(({ fault }) => fault));
  return [
    ...on.map(({ name }) => ['check', `Clear ${name}`, () => app.orders.ask(`clear ${name}`, () => app.commands.clearFault(name))]),
    ...quick.filter(([, { type }]) => !there.has(type)).map(([words, fault]) => ['fault', words, () => app.orders.inject({ ...fault, ...target })]),
    ['fault', 'Inject fault…', () => app.orders.fillInFault(target)],
  ];
}

function concerns(fault, { robot, door, lane }) {
  if (lane) return fault.lane !== undefined && lane.every((end) => fault.lane.includes(end));
  return robot !== undefined ? fault.robot === robot : fault.door === door;
}
