/** The orders of the demand, and their state. */

import { secondsOf } from './messages.js';
import { Tail } from './tail.js';

const ENDED = 200;
const MAX_LEFT = 200;

/**
 * @typedef {typeof UNKNOWN} Order Immutable. `from` is the item's place when the order was placed; `state` is waiting,
 *   carried, delivered or lost; `robot` carries the item or has delivered it; from `due` on the order is late. Times are
 *   simulated seconds, `lead` the seconds from placing to delivery, `lateBy` those of delay. What is unknown is "" or null.
 */
const UNKNOWN = {
  name: '', item: '', from: '', to: '', priority: 0, state: 'waiting', robot: '', placed: null, due: null, late: false,
  ended: null, lead: null, lateBy: 0,
};

/** How an order changes in each step, by the `step` that kinds of events set. */
const STEPS = new Map(Object.entries({
  placed: (order, { from = '', to = '', priority = 0, within = null }, time) => {
    return { ...order, from, to, priority, placed: time, due: within === null ? null : time + within };
  },
  picked_up: (order, { robot = '' }) => ({ ...order, state: 'carried', robot }),
  late: (order, { to = order.to }, time) => ({ ...order, to, due: order.due ?? time, late: true }),
  delivered: (order, { robot = '', lead_time: lead = null, late = 0 }, time) => {
    return { ...order, state: 'delivered', robot, ended: time, lead, lateBy: late, late: late > 0 };
  },
  lost: (order, _event, time) => ({ ...order, state: 'lost', robot: '', ended: time }),
}));

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
    /** @type {Map<string, Order>} */
    this.open = new Map(); // the open orders by name
    this.totals = { placed: 0, delivered: 0, late: 0, lost: 0 }; // the numbers of orders
    this._ended = new Tail(ENDED);
    this._left = new Map(); // orders that are no longer open and whose last event has not arrived
    this._loaded = -Infinity; // the time of the loaded state, which includes all earlier events
  }

  /** @returns {Order[]} The latest ended orders, oldest first. */
  get ended() { return this._ended.items; }

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
    const take = STEPS.get(step);
    if (!take || !name) return;
    const order = take(this.open.get(name) ?? this._left.get(name) ?? { ...UNKNOWN, name, item }, event, time);
    const ends = order.ended !== null;
    if (ends && !this.ended.some((each) => each.name === name && each.ended === time)) this._ended.push(order);
    if (ends) this._left.delete(name);
    if (time <= this._loaded) return;
    if (ends) this.open.delete(name);
    else this.open.set(name, order);
    if (step in this.totals) this.totals = { ...this.totals, [step]: this.totals[step] + 1 };
  }

  copy() {
    const copies = { open: new Map(this.open), _ended: this._ended.copy(), _left: new Map(this._left) };
    return Object.assign(new Demand(), this, copies);
  }
}

/** Return an order of `_world/demand`. */
function orderOf({ name, item, at = '', to = '', priority = 0, state = 'waiting', robot = '', late = false, placed, due }) {
  const timeOf = (stamp) => (stamp ? secondsOf(stamp) : null);
  return { ...UNKNOWN, name, item, from: at, to, priority, state, robot, late, placed: timeOf(placed), due: timeOf(due) };
}
