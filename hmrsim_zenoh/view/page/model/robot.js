/** One robot: where it is at a time, how it is, and what it does. */

import { Motion, NO_WAY, Way, samePlace } from './motion.js';
import { Tail } from './tail.js';

/** What a robot may be doing, in the order in which they count. */
export const STATES = Object.freeze(['offline', 'stopped', 'waiting', 'driving', 'charging', 'busy', 'idle']);

/** Actions that do not hold a robot: others may drive it meanwhile. */
const BESIDE = new Set([
  'compute_and_track_route', 'compute_path_through_poses', 'compute_path_to_pose', 'compute_route', 'smooth_path',
]);
const DRIVEN = 400;
const NONE = Object.freeze([]);
const WELL = Object.freeze({});
const NOWHERE = new Motion({ from: [0, 0, 0] }, -Infinity);

/**
 * What is said of it is replaced and never changed, so that it can be saved as it is.
 *
 * @typedef {import('./motion.js').Point} Point
 * @typedef {{percentage: number, charging: boolean}} Battery `percentage` is from 0 to 1.
 * @typedef {{name: string, range: number, field_of_view: number|null, blind: boolean}} Sensor
 * @typedef {{id: string, kind: string, at: number[]}} Detection `at` is x, y, yaw.
 */
export class Robot {
  constructor(name, type = '') {
    this.name = name;
    this.type = type;
    /** @type {number} Of the footprint; 0 if it has none. */
    this.radius = 0;
    this.flies = false;
    /** @type {number|null} The greatest speed that it can go now. */
    this.speed = null;
    /** @type {boolean} Whether it can be reached. */
    this.connected = true;
    /** @type {Motion|null} What it drives, or drove last; null once it was stopped, and while it waits. */
    this.motion = null;
    /** @type {boolean} Whether something is in its way, so that it stands on its way. */
    this.waits = false;
    /** @type {readonly string[]} The robots for which it waits. */
    this.waitsFor = NONE;
    /** @type {string} What it waits for that is no robot, such as a door; or "". */
    this.waitsWhy = '';
    /** @type {number|null} Since when it waits. */
    this.waitsSince = null;
    /** @type {{dock: string, position: number, goal?: string}|null} The dock in whose queue it stands, and for which goal. */
    this.queue = null;
    /** @type {string|null} The robot for which it moved aside, where it stays until it may go on. */
    this.aside = null;
    this._makesRoom = false;
    /** @type {string|null} The dock where it is docked. */
    this.dock = null;
    /** @type {readonly string[]} The items that it carries. */
    this.holds = NONE;
    /** @type {Readonly<Record<string, string>>} Why it can do nothing, by cause. */
    this.ailments = WELL;
    /** @type {Battery|null} */
    this.battery = null;
    /** @type {''|'low'|'critical'|'empty'} The level that its battery was last told to have come down to. */
    this.batteryLevel = '';
    /** @type {readonly Sensor[]} */
    this.sensors = NONE;
    /** @type {readonly Detection[]} What it sees, as last received. */
    this.detections = NONE;
    /** @type {readonly import('./goals.js').Goal[]} Its goals that have not ended, in order of acceptance. */
    this.goals = NONE;
    /** @type {{orders: number, done: number, state: string, error: string}|null} How its script ended. */
    this.script = null;
    /** @type {readonly string[]} Names of its actions, by `_world/info`. */
    this.actions = NONE;
    /** @type {readonly string[]} Names of its components, by `_world/info`. */
    this.components = NONE;
    /** @type {string} What plans its ways: `graph` or `external`. */
    this.planner = 'graph';
    /** @type {Motion} What it drives or drove last, or how it stands; before that what came earlier. */
    this._track = NOWHERE;
    /** @type {readonly Motion[]} What it drives after that, unless something comes first. */
    this._coming = NONE;
    /** @type {Way} */
    this._way = NO_WAY;
    /** @type {Tail<[number, number, number]>} */
    this._driven = new Tail(DRIVEN);
  }

  /** Return where it is at a time, or was a short while before the last thing that is known. */
  poseAt(time, out = [0, 0, 0]) {
    if (this._coming.length) this._driveUpTo(time);
    return this._track.at(time).poseAt(time, out);
  }

  /** Return what it does at a time: one of `STATES`. */
  stateAt(time) {
    if (!this.connected) return 'offline';
    if (this.ailments !== WELL) return 'stopped';
    if (this.waits) return 'waiting';
    if (this.movesAt(time)) return 'driving';
    if (this.aside !== null && this.goal !== null) return 'waiting';
    if (this.battery !== null && this.battery.charging) return 'charging';
    return this.goal !== null ? 'busy' : 'idle';
  }

  /** Return whether it moves at a time. Where a piece ends before the way does, the next one is on its way to us. */
  movesAt(time) {
    if (this._coming.length) this._driveUpTo(time);
    return this.motion !== null && !this.waits && (time < this.motion.ends || this._way.goesOn);
  }

  /** Return what is left of its way; rides in lifts are no distance. */
  distanceRemaining(time) {
    return this._way.remaining(this.poseAt(time, scratch));
  }

  /** @returns {number} Until when it moves by what is known, in simulated seconds. */
  get ends() {
    return (this._coming.at(-1) ?? this.motion)?.ends ?? -Infinity;
  }

  /** @returns {readonly Point[]} The points that it still drives to; none when it stands. */
  get route() {
    return this._way.ahead;
  }

  /** @returns {[number, number, number][]} Where it has driven: x, y and when; oldest first, without where it is now. */
  get driven() {
    return this._driven.items;
  }

  /** @returns {import('./goals.js').Goal|null} The goal that holds it, or null. */
  get goal() {
    for (let i = this.goals.length - 1; i >= 0; i -= 1) {
      if (!BESIDE.has(this.goals[i].action)) return this.goals[i];
    }
    return null;
  }

  /** Begin a motion. @param {...Motion} coming What it drives after that. */
  begin(motion, ...coming) {
    if (this._coming.length) this._driveUpTo(motion.began);
    this._begin(motion);
    this._coming = coming;
  }

  /** Begin those motions that have begun by a time. */
  _driveUpTo(time) {
    let begun = 0;
    while (begun < this._coming.length && this._coming[begun].began <= time) {
      this._begin(this._coming[begun]);
      begun += 1;
    }
    if (begun) this._coming = this._coming.slice(begun);
  }

  _begin(motion) {
    this._follow(motion);
    this.motion = motion;
    this.waits = false;
    this._settled();
    this.queue = null;
    if (!motion.turns) this._drivenTo(motion.from[0], motion.from[1], motion.began);
    this._way = this._way.on(motion);
  }

  /**
   * Take a way.
   * @param {readonly Point[]} points Those that it is going to drive to.
   * @param {(a: Point, b: Point) => boolean} rides Whether from one point to the next it is carried.
   */
  take(points, rides) {
    // The first way after it was asked to is the one aside.
    if (!this._makesRoom) this.aside = null;
    this._makesRoom = false;
    this._way = Way.along(points, rides);
  }

  /** Stop where it is. @param {Point} [at] Where that is. */
  stop(time, at) {
    this.poseAt(time, scratch);
    const [x, y] = at ?? scratch;
    this._stand(time, x, y, scratch[2]);
    this._stay();
    this._drivenTo(x, y, time);
  }

  /** Be somewhere else at once. */
  put(time, x, y, yaw) {
    this._track = NOWHERE;
    this._stand(time, x, y, yaw);
    this._stay();
    this._driven.clear();
  }

  /** Stand where a scene says, without forgetting the way there if it is not far from where it was believed to be. */
  arrive(time, x, y, yaw) {
    this.poseAt(time, scratch);
    if (!samePlace(scratch, [x, y])) this._driven.clear();
    this._track = NOWHERE;
    this._stand(time, x, y, yaw);
    this._stay();
  }

  /**
   * Stand on its way, where it has got to or has not set out from after all.
   * @param {readonly string[]} robots For which robots.
   * @param {string} why For what else it waits.
   * @param {Point} [at] Where.
   */
  wait(time, robots, why, at) {
    this.poseAt(time, scratch);
    const [x, y] = at ?? scratch;
    this._way = this._way.from([x, y]);
    // It faces where it is going to drive.
    const next = this._way.ahead[0];
    const faces = next && !samePlace(next, [x, y]);
    this._stand(time, x, y, faces ? Math.atan2(next[1] - y, next[0] - x) : scratch[2]);
    if (!this.waits) this.waitsSince = time;
    this.waits = true;
    this.waitsFor = robots;
    this.waitsWhy = why;
  }

  /** Move aside for another robot: drive to where `take` leads next, and stay there until it may go on. */
  makeRoom(by) {
    this.aside = by;
    this._makesRoom = true;
  }

  /** Wait no longer. */
  goOn() {
    this.waits = false;
    this._settled();
  }

  /** Be disabled for a reason, or no longer. @param {string|null} why Null when it is over. */
  disable(what, why) {
    const { [what]: _, ...others } = this.ailments;
    this.setAilments(why === null ? others : { ...others, [what]: why });
  }

  setAilments(ailments) {
    this.ailments = Object.keys(ailments).length ? ailments : WELL;
  }

  /** @returns {object} What `restore` takes. */
  saved() {
    return { ...this, _driven: this._driven.saved() };
  }

  restore(saved) {
    const driven = this._driven;
    Object.assign(this, saved);
    driven.restore(saved._driven);
    this._driven = driven;
  }

  /** Forget the way that it has driven. */
  forgetDriven() {
    this._driven.clear();
  }

  _settled() {
    this.waitsFor = NONE;
    this.waitsWhy = '';
    this.waitsSince = null;
  }

  /** Stand still from a time on. */
  _stand(time, x, y, yaw) {
    const at = [x, y, yaw];
    this._coming = NONE;
    this._follow(new Motion({ from: at, to: at }, time));
    this.motion = null;
  }

  /** Have nowhere to go. */
  _stay() {
    this.waits = false;
    this._settled();
    this.queue = this.aside = null;
    this._way = NO_WAY;
  }

  _follow(motion) {
    this._track = motion.after(this._track === NOWHERE ? null : this._track);
  }

  _drivenTo(x, y, time) {
    const last = this._driven.last;
    if (last === undefined || last[0] !== x || last[1] !== y) this._driven.push([x, y, time]);
  }
}

const scratch = [0, 0, 0];
