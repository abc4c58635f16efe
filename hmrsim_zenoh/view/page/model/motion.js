/**
 * How a robot moves: a piece of way, or a turn, whose pose is a formula of time; the same as in hmrsim/motion.py.
 *
 * @typedef {[number, number]} Point x, y in the world's unit.
 * @typedef {[number, number, number]} Pose x, y, yaw; the yaw in radians from +x to +y.
 */

const REMEMBERED = 8;

/** Driving a distance from rest to rest, with a greatest speed and an acceleration; a triangle where it is short. */
class Trapezoid {
  /**
   * @param {number} distance
   * @param {number} speed
   * @param {number} acceleration
   */
  constructor(distance, speed, acceleration) {
    this.distance = distance;
    this.speed = speed;
    this.acceleration = acceleration;
    const reached = Math.min(speed, Math.sqrt(distance * acceleration));
    /** Seconds of speeding up, which are those of slowing down. */
    this.rampSeconds = reached / acceleration;
    /** Distance of speeding up. */
    this.rampLength = (reached * reached) / (2 * acceleration);
    /** Seconds from rest to rest. */
    this.duration = 2 * this.rampSeconds + (distance - 2 * this.rampLength) / speed;
  }

  /**
   * Return the seconds after which a distance has been driven.
   * @param {number} distance
   * @returns {number}
   */
  time(distance) {
    if (distance <= this.rampLength) return Math.sqrt((2 * distance) / this.acceleration);
    if (distance <= this.distance - this.rampLength) {
      return this.rampSeconds + (distance - this.rampLength) / this.speed;
    }
    return this.duration - Math.sqrt((2 * Math.max(0, this.distance - distance)) / this.acceleration);
  }

  /**
   * Return the distance that has been driven after some seconds.
   * @param {number} time
   * @returns {number}
   */
  driven(time) {
    if (time <= this.rampSeconds) return (this.acceleration * time * time) / 2;
    if (time <= this.duration - this.rampSeconds) return this.rampLength + (time - this.rampSeconds) * this.speed;
    const left = Math.max(0, this.duration - time);
    return this.distance - (this.acceleration * left * left) / 2;
  }
}

/**
 * Return the motions that an event `motion` says, one after the other.
 * @param {{duration?: number, then?: object[]}} said
 * @param {number} began In simulated seconds.
 * @returns {Motion[]}
 */
export function motionsOf(said, began) {
  const motions = [];
  for (const each of [said, ...(said.then ?? [])]) {
    motions.push(new Motion(each, began));
    began += each.duration ?? 0;
  }
  return motions;
}

/** One lane driven, one turn made or one ride: what the event `motion` says, and when it began. */
export class Motion {
  /**
   * @param {{from?: number[], to?: number[], duration?: number, lane?: string[]|null, turned?: number,
   *   ride?: boolean, profile?: number[]}} said
   * @param {number} began In simulated seconds.
   */
  constructor(said, began) {
    const from = said.from ?? said.to ?? [0, 0, 0];
    const to = said.to ?? from;
    /** @type {Pose} */
    this.from = [from[0], from[1], from[2] ?? 0];
    /** @type {Pose} */
    this.to = [to[0], to[1], to[2] ?? this.from[2]];
    /** @type {number} Seconds. */
    this.duration = said.duration ?? 0;
    this.began = began;
    this.ends = began + this.duration;
    /** @type {string[]|null} The waypoints of the lane that is driven. */
    this.lane = said.lane ?? null;
    /** @type {boolean} Whether one is carried, and is where it began until it is over. */
    this.ride = said.ride === true;
    /** @type {boolean} Whether it is a turn. */
    this.turns = said.turned !== undefined;
    /** @type {number} Radians of a turn. */
    this.turned = said.turned ?? 0;
    const stays = this.turns || this.ride;
    /** @type {number} What is driven. */
    this.length = stays ? 0 : Math.hypot(this.to[0] - this.from[0], this.to[1] - this.from[1]);
    /** @type {Trapezoid|null} The speed over the stretch of which this is a part. */
    this.profile = said.profile ? new Trapezoid(said.profile[0], said.profile[1], said.profile[2]) : null;
    /** @type {Motion|null} */
    this._earlier = null;
    this._before = said.profile?.[3] ?? 0;
    this._offset = this.profile ? this.profile.time(this._before) : 0;
  }

  /**
   * Remember what came before, for a while: what is shown may be behind what is known.
   * @param {Motion|null} earlier
   * @returns {Motion} Itself.
   */
  after(earlier) {
    // What began at this very instant has not been.
    while (earlier !== null && earlier.began >= this.began) earlier = earlier._earlier;
    this._earlier = earlier;
    for (let i = 0; i < REMEMBERED && earlier !== null; i += 1) earlier = earlier._earlier;
    if (earlier !== null) earlier._earlier = null;
    return this;
  }

  /**
   * Return what was driven at a time: this, or what came before it.
   * @param {number} time In simulated seconds.
   * @returns {Motion}
   */
  at(time) {
    let motion = this;
    while (time < motion.began && motion._earlier !== null) motion = motion._earlier;
    return motion;
  }

  /**
   * Return the length that has been driven at a time, from 0 to `length`.
   * @param {number} time In simulated seconds.
   * @returns {number}
   */
  drivenAt(time) {
    const elapsed = time - this.began;
    if (elapsed >= this.duration) return this.length;
    if (elapsed <= 0) return 0;
    if (this.profile === null) return (this.length * elapsed) / this.duration;
    return Math.min(this.length, Math.max(0, this.profile.driven(this._offset + elapsed) - this._before));
  }

  /**
   * Return the pose at a time; before its beginning where it begins, and after its end where it ends.
   * @param {number} time In simulated seconds.
   * @param {number[]} [out] Is filled and returned.
   * @returns {number[]}
   */
  poseAt(time, out = [0, 0, 0]) {
    const { from, to } = this;
    const elapsed = time - this.began;
    if (elapsed >= this.duration) {
      out[0] = to[0];
      out[1] = to[1];
      out[2] = to[2];
      return out;
    }
    out[0] = from[0];
    out[1] = from[1];
    out[2] = from[2];
    if (elapsed <= 0) return out;
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
