/** The way ahead of a robot: the points that it still drives to, and how long it is from each to the last. */

const SAME_PLACE = 1e-6;
const NONE = Object.freeze([]);

/**
 * It is never changed.
 *
 * @typedef {import('./motion.js').Point} Point
 */
export class Way {
  /**
   * @param {readonly Point[]} points
   * @param {readonly number[]} lengths From each point to the last.
   * @param {number} next To which it drives now.
   * @param {boolean} rides Whether it is carried there.
   */
  constructor(points, lengths, next, rides) {
    this._points = points;
    this._lengths = lengths;
    this._next = next;
    this._rides = rides;
    /** @type {readonly Point[]|null} */
    this._ahead = next ? null : points;
  }

  /**
   * Return the way along points.
   * @param {readonly Point[]} points Those that are going to be driven to.
   * @param {(a: Point, b: Point) => boolean} rides Whether from one point to the next one is carried.
   * @returns {Way}
   */
  static along(points, rides) {
    const lengths = new Array(points.length);
    for (let i = points.length - 1, length = 0; i >= 0; i -= 1) {
      lengths[i] = length;
      if (i && !rides(points[i - 1], points[i])) length += apart(points[i - 1], points[i]);
    }
    return new Way(points, lengths, 0, false);
  }

  /** @returns {readonly Point[]} The points that are still driven to. */
  get ahead() {
    if (this._ahead === null) this._ahead = this._points.slice(this._next);
    return this._ahead;
  }

  /** @returns {boolean} Whether it goes on behind the point that is driven to now. */
  get goesOn() {
    return this._next < this._points.length - 1;
  }

  /**
   * Return the way when a motion begins on it.
   * @param {import('./motion.js').Motion} motion
   * @returns {Way}
   */
  on(motion) {
    if (motion.turns) return this.from(motion.from);
    for (let i = this._next; i < this._points.length; i += 1) {
      if (!samePlace(this._points[i], motion.to)) continue;
      return i === this._next && motion.ride === this._rides
        ? this
        : new Way(this._points, this._lengths, i, motion.ride);
    }
    return this;
  }

  /**
   * Return the way of a robot that stands at a point of it.
   * @param {readonly number[]} at
   * @returns {Way}
   */
  from(at) {
    const next = this.goesOn && samePlace(this._points[this._next], at) ? this._next + 1 : this._next;
    return next === this._next && !this._rides ? this : new Way(this._points, this._lengths, next, false);
  }

  /**
   * Return how long it is from a pose to its end; rides in lifts are no distance.
   * @param {readonly number[]} pose
   * @returns {number}
   */
  remaining(pose) {
    const next = this._points[this._next];
    return next ? (this._rides ? 0 : apart(next, pose)) + this._lengths[this._next] : 0;
  }
}

/** The way of a robot that stands. */
export const NO_WAY = new Way(NONE, NONE, 0, false);

/**
 * Return whether two points are one.
 * @param {readonly number[]} a
 * @param {readonly number[]} b
 * @returns {boolean}
 */
export function samePlace(a, b) {
  return Math.abs(a[0] - b[0]) <= SAME_PLACE && Math.abs(a[1] - b[1]) <= SAME_PLACE;
}

function apart(a, b) {
  return Math.hypot(a[0] - b[0], a[1] - b[1]);
}
