/** The numbers of robots in each state, and their batteries, over time. */

import { STATES, countStates } from './robot.js';

const MAX_POINTS = 1000;
const BEGIN_SECONDS = 1;

/** Numbers over time. When there are too many, every other one is dropped. */
class Series {
  /** @param {number} columns The count of numbers at each time. */
  constructor(columns) {
    this.t = [];
    this.columns = Array.from({ length: columns }, () => []);
    this.seconds = BEGIN_SECONDS;
  }

  /** Drop every other time, and record half as often from now on. */
  thin() {
    const half = (all) => all.filter((_, i) => i % 2 === 0);
    this.t = half(this.t);
    this.columns = this.columns.map(half);
    this.seconds *= 2;
  }

  copy() {
    const copy = new Series(0);
    copy.t = this.t.slice();
    copy.columns = this.columns.map((column) => column.slice());
    copy.seconds = this.seconds;
    return copy;
  }
}

/** The data of charts, with at most 1,000 points each. */
export class History {
  constructor() {
    this.clear();
  }

  clear() {
    this._counts = new Series(STATES.length);
    this.batteries = new Map(); // robots' batteries, [time, share] each
    this._gaps = new Map();
    this._next = -Infinity;
  }

  /** @returns {number[]} The times, in simulated seconds. */
  get t() {
    return this._counts.t;
  }

  /** @returns {Record<string, number[]>} How many robots were in each state at those times. */
  get counts() {
    return Object.fromEntries(STATES.map((state, i) => [state, this._counts.columns[i]]));
  }

  /** Count the robots at the times up to *time* that are due; nothing may have happened since the last one. */
  advance(time, robots) {
    if (time < this._next) return;
    const { seconds } = this._counts;
    const last = Math.floor(time / seconds) * seconds;
    const first = this._next === -Infinity ? last : this._next;
    this._count(first, robots);
    // Nothing has happened in between, so two points are enough.
    if (last > first) this._count(last, robots);
    this._next = last + this._counts.seconds;
  }

  /** Record a battery's charge. @param {number} share From 0 to 1. */
  battery(robot, time, share) {
    let points = this.batteries.get(robot);
    if (points === undefined) this.batteries.set(robot, (points = []));
    const gap = this._gaps.get(robot) ?? BEGIN_SECONDS;
    if (points.length > 1 && time - points[points.length - 2][0] < gap) {
      points[points.length - 1] = [time, share];
      return;
    }
    points.push([time, share]);
    if (points.length > MAX_POINTS) {
      this.batteries.set(robot, points.filter((_, i) => i % 2 === 0));
      this._gaps.set(robot, gap * 2);
    }
  }

  /** @returns {object} What `restore` takes. */
  saved() {
    const batteries = [...this.batteries].map(([name, points]) => [name, points.slice()]);
    return { counts: this._counts.copy(), batteries, gaps: [...this._gaps], next: this._next };
  }

  restore(saved) {
    this._counts = saved.counts.copy();
    this.batteries = new Map(saved.batteries.map(([name, points]) => [name, points.slice()]));
    this._gaps = new Map(saved.gaps);
    this._next = saved.next;
  }

  _count(time, robots) {
    this._counts.t.push(time);
    Object.values(countStates(robots, time)).forEach((count, i) => this._counts.columns[i].push(count));
    if (this._counts.t.length > MAX_POINTS) this._counts.thin();
  }
}
