/** The orders of the demand: what has to be brought where, and what has become of it. */

import { secondsOf } from './messages.js';
import { Tail } from './tail.js';

/**
 * @typedef {object} Order It is never changed: another takes its place.
 * @property {string} name
 * @property {string} item
 * @property {string} from Where the item was when the order came; "" if that is not known.
 * @property {string} to Likewise.
 * @property {number} priority
 * @property {'waiting'|'carried'|'delivered'|'lost'} state
 * @property {string} robot Which carries the item, or has brought it; "" for none.
 * @property {number|null} placed When, in simulated seconds; null if that is not known.
 * @property {number|null} due When it is late; null for never.
 * @property {boolean} late
 * @property {number|null} ended
 * @property {number|null} lead Seconds from its coming to its delivery.
 * @property {number} lateBy Seconds that it was delivered late.
 */

const ENDED = 200;
const MAX_LEFT = 200;
/** @type {Order} */
const UNKNOWN = {
  name: '', item: '', from: '', to: '', priority: 0, state: 'waiting', robot: '', placed: null, due: null, late: false,
  ended: null, lead: null, lateBy: 0,
};

/** What each step of an order makes of it, by what events of its kind set as `step`; and the total that counts it. */
const STEPS = {
  placed: {
    total: 'placed',
    take: (order, { from = '', to = '', priority = 0, within = null }, time) => {
      return { ...order, from, to, priority, placed: time, due: within === null ? null : time + within };
    },
  },
  picked_up: { take: (order, { robot = '' }) => ({ ...order, state: 'carried', robot }) },
  late: { total: 'late', take: (order, { to = order.to }, time) => ({ ...order, to, due: order.due ?? time, late: true }) },
  delivered: {
    total: 'delivered',
    take: (order, { robot = '', lead_time: lead = null, late = 0 }, time) => {
      return { ...order, state: 'delivered', robot, ended: time, lead, lateBy: late, late: late > 0 };
    },
  },
  lost: { total: 'lost', take: (order, _event, time) => ({ ...order, state: 'lost', robot: '', ended: time }) },
};

/** Return an order as its item is, which may have been put down on the way. */
export function asItemIs(order, items) {
  const item = order.ended === null ? items.get(order.item) : undefined;
  if (!item) return order;
  return { ...order, state: item.carrier === null ? 'waiting' : 'carried', robot: item.carrier ?? '' };
}

/** All orders that are known, from what `_world/demand` says and from events. */
export class Demand {
  constructor() {
    this.clear();
  }

  /** Know of none. */
  clear() {
    /** @type {Map<string, Order>} Those to be served, by name. */
    this.open = new Map();
    /** @type {{placed: number, delivered: number, late: number, lost: number}} How many there were. */
    this.totals = { placed: 0, delivered: 0, late: 0, lost: 0 };
    this._ended = new Tail(ENDED);
    this._left = new Map(); // open ones that are open no more; the event that says why is still to come
    this._told = -Infinity; // what happened until then is in what was loaded
  }

  /** @returns {Order[]} The last that have ended, oldest first. */
  get ended() {
    return this._ended.items;
  }

  /** Be as the simulator says. @param {object} said `_world/demand`. */
  load({ stamp, orders, totals }) {
    const before = this.open;
    this.open = new Map(orders.map((order) => [order.name, orderOf(order)]));
    if (this._left.size > MAX_LEFT) this._left.clear();
    for (const [name, order] of before) if (!this.open.has(name)) this._left.set(name, order);
    this.totals = { ...this.totals, ...totals };
    this._told = secondsOf(stamp);
  }

  /** Take note of a step of an order. */
  note(event, time) {
    const { step, order: name, item } = event;
    const found = Object.hasOwn(STEPS, step) ? STEPS[step] : undefined;
    if (!found || !name) return;
    const known = this.open.get(name) ?? this._left.get(name) ?? { ...UNKNOWN, name, item };
    const order = found.take(known, event, time);
    if (order.ended !== null && !this.ended.some((each) => each.name === name && each.ended === time)) this._ended.push(order);
    if (order.ended !== null) this._left.delete(name);
    if (time <= this._told) return;
    if (order.ended === null) this.open.set(name, order);
    else this.open.delete(name);
    if (found.total) this.totals = { ...this.totals, [found.total]: this.totals[found.total] + 1 };
  }

  /** @returns {object} What `restore` takes. */
  saved() {
    return { open: new Map(this.open), totals: this.totals, ended: this._ended.saved(), left: new Map(this._left), told: this._told };
  }

  restore({ open, totals, ended, left, told }) {
    this.open = new Map(open);
    this.totals = totals;
    this._ended.restore(ended);
    this._left = new Map(left);
    this._told = told;
  }
}

/** Return an order as `_world/demand` has it. */
function orderOf({ name, item, at = '', to = '', priority = 0, state = 'waiting', robot = '', late = false, placed, due }) {
  return { ...UNKNOWN, name, item, from: at, to, priority, state, robot, late, placed: timeOf(placed), due: timeOf(due) };
}

function timeOf(stamp) {
  return stamp ? secondsOf(stamp) : null;
}
