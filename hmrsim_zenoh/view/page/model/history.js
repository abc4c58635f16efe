/** The numbers of robots in each state, their batteries, and other numbers over time. */

import { STATES, countStates } from './robot.js';

const MAX_POINTS = 1000;
const MAX_LINE = 300; // points of a line, of which there may be one for each robot
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

/** A number over time, as [time, number] of each point. When there are too many, every other one is dropped. */
export class Line {
  /** @param {number} [gap] The least seconds from one point to the next. */
  constructor(gap = BEGIN_SECONDS, points = []) {
    this.points = points;
    this.gap = gap;
  }

  add(time, value) {
    const { points } = this;
    // Time has begun anew.
    if (points.length && time < points.at(-1)[0]) points.length = 0;
    if (points.length > 1 && time - points.at(-2)[0] < this.gap) points.pop();
    points.push([time, value]);
    if (points.length <= MAX_LINE) return;
    this.points = points.filter((_, i) => i % 2 === 0);
    this.gap *= 2;
  }

  copy() {
    return new Line(this.gap, this.points.slice());
  }
}

/** The data of charts. */
export class History {
  constructor() {
    this.clear();
  }

  clear() {
    this._counts = new Series(STATES.length);
    /** @type {Map<string, Line>} */
    this.batteries = new Map(); // robots' batteries
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
    if (!this.batteries.has(robot)) this.batteries.set(robot, new Line());
    this.batteries.get(robot).add(time, share);
  }

  /** @returns {object} What `restore` takes. */
  saved() {
    return { counts: this._counts.copy(), batteries: copied(this.batteries), next: this._next };
  }

  restore(saved) {
    this._counts = saved.counts.copy();
    this.batteries = copied(saved.batteries);
    this._next = saved.next;
  }

  _count(time, robots) {
    this._counts.t.push(time);
    Object.values(countStates(robots, time)).forEach((count, i) => this._counts.columns[i].push(count));
    if (this._counts.t.length > MAX_POINTS) this._counts.thin();
  }
}

function copied(lines) {
  return new Map(Array.from(lines, ([name, line]) => [name, line.copy()]));
}
