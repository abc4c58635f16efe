/** The numbers of robots in each state, their batteries, and other numbers over time. */

import { countStates } from './robot.js';

const MAX_COUNTS = 1000;
const MAX_LINE = 300; // points of a line, of which there may be one for each robot

/** Values over time, as [time, value] of each point. When there are too many, every other one is dropped. */
export class Line {
  /** @param {number} [gap] The least seconds from one point to the next. */
  constructor(gap = 1, most = MAX_LINE, points = []) {
    Object.assign(this, { gap, most, points });
  }

  /** Add a value, in place of the last one if that was within the gap. */
  add(time, value) {
    const { points } = this;
    // Time has begun anew.
    if (points.length && time < points.at(-1)[0]) points.length = 0;
    if (points.length > 1 && time - points.at(-2)[0] < this.gap) points.pop();
    points.push([time, value]);
    if (points.length <= this.most) return;
    this.points = points.filter((_, i) => i % 2 === 0);
    this.gap *= 2;
  }

  copy() { return new Line(this.gap, this.most, this.points.slice()); }
}

/** The data of charts. */
export class History {
  constructor() {
    this.clear();
  }

  clear() {
    this.counts = new Line(1, MAX_COUNTS); // how many robots were in each state, by state
    /** @type {Map<string, Line>} */
    this.batteries = new Map(); // robots' batteries, from 0 to 1
    this._next = -Infinity;
  }

  /** Count the robots at the times up to *time* that are due; nothing may have happened since the last one. */
  advance(time, robots) {
    if (time < this._next) return;
    const { gap } = this.counts;
    const last = Math.floor(time / gap) * gap;
    const first = this._next === -Infinity ? last : this._next;
    this.counts.add(first, countStates(robots, first));
    // Nothing has happened in between, so two points are enough.
    if (last > first) this.counts.add(last, countStates(robots, last));
    this._next = last + this.counts.gap;
  }

  /** Record a battery's charge. @param {number} share From 0 to 1. */
  battery(robot, time, share) {
    if (!this.batteries.has(robot)) this.batteries.set(robot, new Line());
    this.batteries.get(robot).add(time, share);
  }

  copy() {
    const batteries = new Map(Array.from(this.batteries, ([name, line]) => [name, line.copy()]));
    return Object.assign(new History(), this, { counts: this.counts.copy(), batteries });
  }
}
