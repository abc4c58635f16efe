/** The orders of the demand, and their state. */

import { secondsOf } from './messages.js';
import { Tail } from './tail.js';

/**
 * @typedef {object} Order Immutable.
 * @property {string} name
 * @property {string} item
 * @property {string} from The item's place when the order was placed; "" if unknown.
 * @property {string} to The destination; "" if unknown.
 * @property {number} priority
 * @property {'waiting'|'carried'|'delivered'|'lost'} state
 * @property {string} robot The robot that carries the item or has delivered it; "" for none.
 * @property {number|null} placed Simulated seconds; null if unknown.
 * @property {number|null} due The time from which it is late; null for never.
 * @property {boolean} late
 * @property {number|null} ended
 * @property {number|null} lead Seconds from placing to delivery.
 * @property {number} lateBy Seconds of delay at the delivery.
 */

const ENDED = 200;
const MAX_LEFT = 200;
/** @type {Order} */
const UNKNOWN = {
  name: '', item: '', from: '', to: '', priority: 0, state: 'waiting', robot: '', placed: null, due: null, late: false,
  ended: null, lead: null, lateBy: 0,
};

/** How an order changes in each step, by the `step` that kinds of events set, and the total that counts the step. */
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

/** Return an order in the state of its item, which may have been put down on the way. */
export function asItemIs(order, items) {
  const item = order.ended === null ? items.get(order.item) : undefined;
  if (!item) return order;
  return { ...order, state: item.carrier === null ? 'waiting' : 'carried', robot: item.carrier ?? '' };
}

/** All known orders, from `_world/demand` and from events. */
export class Demand {
  constructor() {
    this.clear();
  }

  clear() {
    this.open = new Map(); // the open orders by name
    this.totals = { placed: 0, delivered: 0, late: 0, lost: 0 }; // the numbers of orders
    this._ended = new Tail(ENDED);
    this._left = new Map(); // orders that are no longer open and whose last event has not arrived
    this._loaded = -Infinity; // the time of the loaded state, which includes all earlier events
  }

  /** @returns {Order[]} The latest ended orders, oldest first. */
  get ended() {
    return this._ended.items;
  }

  /** Load the simulator's state. @param {object} demand `_world/demand`. */
  load({ stamp, orders, totals }) {
    const before = this.open;
    this.open = new Map(orders.map((order) => [order.name, orderOf(order)]));
    if (this._left.size > MAX_LEFT) this._left.clear();
    for (const [name, order] of before) if (!this.open.has(name)) this._left.set(name, order);
    this.totals = { ...this.totals, ...totals };
    this._loaded = secondsOf(stamp);
  }

  /** Apply an event about an order. */
  note(event, time) {
    const { step, order: name, item } = event;
    const found = Object.hasOwn(STEPS, step) ? STEPS[step] : undefined;
    if (!found || !name) return;
    const known = this.open.get(name) ?? this._left.get(name) ?? { ...UNKNOWN, name, item };
    const order = found.take(known, event, time);
    if (order.ended !== null && !this.ended.some((each) => each.name === name && each.ended === time)) this._ended.push(order);
    if (order.ended !== null) this._left.delete(name);
    if (time <= this._loaded) return;
    if (order.ended === null) this.open.set(name, order);
    else this.open.delete(name);
    if (found.total) this.totals = { ...this.totals, [found.total]: this.totals[found.total] + 1 };
  }

  /** @returns {object} What `restore` takes. */
  saved() {
    return { open: new Map(this.open), totals: this.totals, ended: this._ended.saved(), left: new Map(this._left), loaded: this._loaded };
  }

  restore({ open, totals, ended, left, loaded }) {
    this.open = new Map(open);
    this.totals = totals;
    this._ended.restore(ended);
    this._left = new Map(left);
    this._loaded = loaded;
  }
}

/** Return an order of `_world/demand`. */
function orderOf({ name, item, at = '', to = '', priority = 0, state = 'waiting', robot = '', late = false, placed, due }) {
  return { ...UNKNOWN, name, item, from: at, to, priority, state, robot, late, placed: timeOf(placed), due: timeOf(due) };
}

function timeOf(stamp) {
  return stamp ? secondsOf(stamp) : null;
}
