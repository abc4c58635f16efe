// The orders of the world's demand: open ones, most urgent first, and the latest ended ones.

import { asItemIs } from '../model/demand.js';
import { clockWords, lastingWords } from '../model/phrases.js';
import { ListPanel, el, mark, say, taskRow } from './dom.js';

const TOTALS = ['open', 'placed', 'delivered', 'late', 'lost'];
/** The goal's sign for each state of an order. */
const SIGNS = { waiting: 'accepted', carried: 'executing', delivered: 'succeeded', lost: 'aborted' };
/** The heading of ended orders in the list. */
const ENDED = { heading: 'Ended' };

export class OrdersPanel extends ListPanel {
  constructor(app) {
    super(app, 'Orders', 'Item, place, robot, state', { height: 58, role: 'table' });
    this.totals = new Map(TOTALS.map((word) => [word, el('dd', { text: '0' })]));
    const totals = [...this.totals].map(([word, number]) => el('div', {}, el('dt', { text: word }), number));
    this.tools = el('div', { class: 'tools' }, el('dl', { class: 'totals', 'aria-label': 'Totals' }, ...totals), this.filter);
    this.place(this.tools);
  }

  /** @param {boolean} seen Whether the panel is open; only then are orders requested. */
  seen(seen) { this.app.live?.watchDemand(seen); }

  render() {
    const { demand, world } = this.app.model;
    const totals = { ...demand.totals, open: demand.open.size };
    for (const [word, number] of this.totals) say(number, totals[word]);
    for (const word of ['late', 'lost']) mark(this.totals.get(word), 'data-some', totals[word] > 0);
    const open = this.matching([...demand.open.values()], (order) => this.#words(order)).sort(byUrgency);
    const ended = this.matching([...demand.ended], (order) => this.#words(order)).reverse();
    const none = demand.open.size === 0 && demand.ended.length === 0;
    this.tools.hidden = none && demand.totals.placed === 0 && world.demand.length === 0;
    const nothing = this.tools.hidden ? 'No orders: this world has no demand.' : 'No order is open.';
    this.showItems(ended.length ? [...open, ENDED, ...ended] : open, none ? nothing : 'No order matches.');
  }

  #words(order) {
    const { name, item, from, to, state, robot, late } = asItemIs(order, this.app.model.items);
    return `${name} ${item} ${from} ${to} ${state} ${robot} ${late ? 'late' : ''}`;
  }

  row() {
    const times = [el('span'), el('span')];
    const row = taskRow(() => this.#show(row.item), ['detail', 'way', 'detail'], el('div', { class: 'order-times', role: 'cell' }, ...times));
    row.classList.add('order');
    Object.assign(row.parts, { times, heading: el('h3', { role: 'cell', text: ENDED.heading }) });
    row.prepend(row.parts.heading);
    return row;
  }

  fill(row, given) {
    const { shape, name, task, status, detail, press, times, heading } = row.parts;
    for (const cell of row.children) cell.hidden = (cell === heading) !== (given === ENDED);
    mark(row, 'data-heading', given === ENDED);
    if (given === ENDED) return mark(row, 'data-selected', 'false');
    const order = asItemIs(given, this.app.model.items);
    const open = order.ended === null;
    const by = order.robot && `by ${order.robot}`;
    const way = [order.from, order.to].map((place) => place || '…').join(' → ');
    mark(shape, 'data-is', SIGNS[order.state] ?? 'unknown');
    say(name, order.item);
    say(task, [order.state, open && by].filter(Boolean).join(' '));
    say(status, way);
    say(detail, !open ? by : order.priority ? `priority ${order.priority}` : '');
    mark(press, 'title', `${order.name}: ${order.item}, ${way}, ${order.state} ${by}`.trim());
    const words = open ? this.#openTimes(order) : endedTimes(order);
    times.forEach((time, i) => {
      say(time, words[i]);
      mark(time, 'data-late', order.late && open === (i === 0));
    });
    return mark(row, 'data-selected', order.robot !== '' && order.robot === this.app.map.selected);
  }

  /** Return the time until an order is late, and its age. */
  #openTimes({ due, placed }) {
    const now = this.app.now();
    const left = due === null ? null : due - now;
    return [
      left === null ? '' : left < 0 ? `${lastingWords(-left)} late` : `due in ${lastingWords(left)}`,
      placed === null ? '' : `${lastingWords(Math.max(0, now - placed))} old`,
    ];
  }

  /** Show the order's robot, or else its item, destination or origin. */
  #show(order) {
    const { robot, item, to, from } = asItemIs(order, this.app.model.items);
    this.app.show([robot, item, to, from]);
  }
}

/** Compare orders: earliest due time first, then higher priority, then age. */
function byUrgency(one, other) {
  const dues = [one, other].map(({ due }) => due ?? Infinity);
  if (dues[0] !== dues[1]) return dues[0] - dues[1];
  return other.priority - one.priority || (one.placed ?? 0) - (other.placed ?? 0);
}

function endedTimes({ state, lead, late, lateBy, ended }) {
  const took = state === 'delivered' && lead !== null ? `took ${lastingWords(lead)}` : '';
  return [took, state === 'delivered' && late ? `${lastingWords(lateBy)} late` : `at ${clockWords(ended)}`];
}
