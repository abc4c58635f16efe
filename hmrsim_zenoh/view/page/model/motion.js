/** How a robot moves, as in hmrsim/motion.py: motions whose pose is a formula of time, and the path ahead. */

/** @typedef {[number, number]} Point x, y in the world's unit; a pose has a yaw, too, in radians from +x to +y. */

const REMEMBERED = 8;

/** A speed profile over a distance from rest to rest, with limits of speed and acceleration. */
class Trapezoid {
  constructor(distance, speed, acceleration) {
    Object.assign(this, { distance, speed, acceleration });
    const reached = Math.min(speed, Math.sqrt(distance * acceleration));
    this.rampSeconds = reached / acceleration; // seconds of acceleration, and of deceleration
    this.rampLength = (reached * reached) / (2 * acceleration); // distance of acceleration
    this.duration = 2 * this.rampSeconds + (distance - 2 * this.rampLength) / speed; // seconds from rest to rest
  }

  /** Return the time at which a distance has been driven. */
  time(distance) {
    if (distance <= this.rampLength) return Math.sqrt((2 * distance) / this.acceleration);
    if (distance <= this.distance - this.rampLength) return this.rampSeconds + (distance - this.rampLength) / this.speed;
    return this.duration - Math.sqrt((2 * Math.max(0, this.distance - distance)) / this.acceleration);
  }

  /** Return the distance driven after a time. */
  driven(time) {
    if (time <= this.rampSeconds) return (this.acceleration * time * time) / 2;
    if (time <= this.duration - this.rampSeconds) return this.rampLength + (time - this.rampSeconds) * this.speed;
    const left = Math.max(0, this.duration - time);
    return this.distance - (this.acceleration * left * left) / 2;
  }
}

/** Return the consecutive motions of an event `motion`. */
export function motionsOf(said, began) {
  const motions = [new Motion(said, began)];
  for (const each of said.then ?? []) motions.push(new Motion(each, motions.at(-1).ends));
  return motions;
}

/** One motion of an event `motion`: along a lane, a turn or a ride in a lift. */
export class Motion {
  constructor(said, began) {
    const from = said.from ?? said.to ?? [0, 0, 0];
    const to = said.to ?? from;
    this.from = [from[0], from[1], from[2] ?? 0];
    this.to = [to[0], to[1], to[2] ?? this.from[2]];
    this.duration = said.duration ?? 0; // seconds
    this.began = began;
    this.ends = began + this.duration;
    this.ride = said.ride === true; // whether it is a ride, during which the pose stays that of the beginning
    this.turns = said.turned !== undefined; // whether it is a turn
    this.turned = said.turned ?? 0; // the angle of a turn in radians
    const stays = this.turns || this.ride;
    this.length = stays ? 0 : Math.hypot(this.to[0] - this.from[0], this.to[1] - this.from[1]); // the driven length
    /** @type {Trapezoid|null} The speed profile of the stretch that this motion is a part of. */
    this.profile = said.profile ? new Trapezoid(...said.profile) : null;
    this._earlier = null;
    this._before = said.profile?.[3] ?? 0;
    this._offset = this.profile ? this.profile.time(this._before) : 0;
  }

  /** Link to the previous motions, as the page shows a time before the latest event. */
  after(earlier) {
    // Motions that began at this instant never took place.
    while (earlier !== null && earlier.began >= this.began) earlier = earlier._earlier;
    this._earlier = earlier;
    for (let i = 0; i < REMEMBERED && earlier !== null; i += 1) earlier = earlier._earlier;
    if (earlier !== null) earlier._earlier = null;
    return this;
  }

  /** Return the motion at a time: this one or an earlier one. */
  at(time) {
    let motion = this;
    while (time < motion.began && motion._earlier !== null) motion = motion._earlier;
    return motion;
  }

  /** Return the length driven at a time, from 0 to `length`. */
  drivenAt(time) {
    const elapsed = time - this.began;
    if (elapsed >= this.duration) return this.length;
    if (elapsed <= 0) return 0;
    if (this.profile === null) return (this.length * elapsed) / this.duration;
    return Math.min(this.length, Math.max(0, this.profile.driven(this._offset + elapsed) - this._before));
  }

  /** Return the pose at a time, limited to those of its beginning and its end. *out* is filled and returned. */
  poseAt(time, out = [0, 0, 0]) {
    const { from, to } = this;
    const elapsed = time - this.began;
    const ended = elapsed >= this.duration;
    [out[0], out[1], out[2]] = ended ? to : from;
    if (ended || elapsed <= 0) return out;
    if (this.turns || this.ride) {
      out[2] += (this.turned * elapsed) / this.duration;
    } else if (this.length > 0) {
      const share = this.drivenAt(time) / this.length;
      out[0] = share >= 1 ? to[0] : from[0] + (to[0] - from[0]) * share;
      out[1] = share >= 1 ? to[1] : from[1] + (to[1] - from[1]) * share;
    }
    return out;
  }
}

const SAME_PLACE = 1e-6;
const NONE = Object.freeze([]);

/** The path ahead of a robot; immutable. */
export class Path {
  /**
   * @param {readonly number[]} lengths The length from each point to the last.
   * @param {number} next The index of the next point.
   * @param {boolean} rides Whether a lift carries it there.
   */
  constructor(points, lengths, next, rides) {
    this._points = points;
    this._lengths = lengths;
    this._next = next;
    this._rides = rides;
    this._ahead = next ? null : points;
  }

  /**
   * Return the path along points.
   * @param {readonly Point[]} points The points ahead.
   * @param {(a: Point, b: Point) => boolean} rides Whether a lift carries robots from one point to the next.
   */
  static along(points, rides) {
    const lengths = new Array(points.length);
    for (let i = points.length - 1, length = 0; i >= 0; i -= 1) {
      lengths[i] = length;
      if (i && !rides(points[i - 1], points[i])) length += apart(points[i - 1], points[i]);
    }
    return new Path(points, lengths, 0, false);
  }

  /** @returns {readonly Point[]} The points still ahead. */
  get ahead() {
    if (this._ahead === null) this._ahead = this._points.slice(this._next);
    return this._ahead;
  }

  /** @returns {boolean} Whether it goes on after the next point. */
  get goesOn() { return this._next < this._points.length - 1; }

  /** Return the path at the beginning of a motion. */
  on(motion) {
    if (motion.turns) return this.from(motion.from);
    for (let i = this._next; i < this._points.length; i += 1) {
      if (!samePlace(this._points[i], motion.to)) continue;
      return i === this._next && motion.ride === this._rides
        ? this
        : new Path(this._points, this._lengths, i, motion.ride);
    }
    return this;
  }

  /** Return the path of a robot that stands at a point of it. */
  from(at) {
    const next = this.goesOn && samePlace(this._points[this._next], at) ? this._next + 1 : this._next;
    return next === this._next && !this._rides ? this : new Path(this._points, this._lengths, next, false);
  }

  /** Return the length from a pose to the end, without rides in lifts. */
  remaining(pose) {
    const next = this._points[this._next];
    return next ? (this._rides ? 0 : apart(next, pose)) + this._lengths[this._next] : 0;
  }
}

/** The path of a robot at rest. */
export const NO_PATH = new Path(NONE, NONE, 0, false);

/** Return the point halfway between two points. @returns {Point} */
export function middle([ax, ay], [bx, by]) { return [(ax + bx) / 2, (ay + by) / 2]; }

/** Return whether two points are the same. */
export function samePlace(a, b) { return Math.abs(a[0] - b[0]) <= SAME_PLACE && Math.abs(a[1] - b[1]) <= SAME_PLACE; }

function apart(a, b) { return Math.hypot(a[0] - b[0], a[1] - b[1]); }
