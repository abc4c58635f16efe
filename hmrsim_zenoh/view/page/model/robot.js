/** A robot: its pose at a time, its state and its goals. All times are simulated seconds. */

import { Motion, NO_PATH, Path, samePlace } from './motion.js';
import { Tail } from './tail.js';

/** The states of robots, by precedence. */
export const STATES = Object.freeze(['offline', 'stopped', 'waiting', 'driving', 'charging', 'busy', 'idle']);

/** Actions that do not occupy a robot. */
const BESIDE = new Set([
  'compute_and_track_route', 'compute_path_through_poses', 'compute_path_to_pose', 'compute_route', 'smooth_path',
]);
const DRIVEN = 400;
const NONE = Object.freeze([]);
const WELL = Object.freeze({});
const NOWHERE = new Motion({ from: [0, 0, 0] }, -Infinity);

/**
 * Its values are replaced and never changed, so that a shallow copy saves them.
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
    this.radius = 0; // the radius of the footprint; 0 for none
    this.flies = false;
    this.connected = true; // whether messages from it arrive
    this.motion = null; // the current or latest motion; null after a stop, and while it waits
    this.waits = false; // whether it is blocked on its path
    this.waitsFor = NONE; // the robots for which it waits
    this.waitsWhy = ''; // the other reason for waiting, such as a door; or ""
    this.waitsSince = null; // the time since which it waits
    this.queue = null; // its place in a dock's queue, and the goal
    this.aside = null; // the robot that it has let pass and still waits for
    this._makesRoom = false;
    this.dock = null; // the dock where it is docked
    this.holds = NONE; // the items that it carries
    this.ailments = WELL; // the reasons for which it is disabled, by cause
    this.battery = null;
    this.sensors = NONE;
    this.detections = NONE; // the latest detections
    this.goals = NONE; // its active goals, in order of acceptance
    this.script = null; // the result of its script
    this.actions = NONE; // names of its actions, by `_world/info`
    this.components = NONE; // names of its components, by `_world/info`
    this.planner = 'graph'; // the planner of its paths: `graph` or `external`
    this._track = NOWHERE; // the current motion or standstill, linked to earlier ones
    this._coming = NONE; // the planned next motions
    this._path = NO_PATH;
    this._driven = new Tail(DRIVEN);
  }

  /** Return the pose at a time, which may be a little before the latest event. *out* is filled and returned. */
  poseAt(time, out = [0, 0, 0]) {
    if (this._coming.length) this._driveUpTo(time);
    return this._track.at(time).poseAt(time, out);
  }

  /** Return the state at a time: one of `STATES`. */
  stateAt(time) {
    if (!this.connected) return 'offline';
    if (this.ailments !== WELL) return 'stopped';
    if (this.waits) return 'waiting';
    if (this.movesAt(time)) return 'driving';
    if (this.aside !== null && this.goal !== null) return 'waiting';
    if (this.battery !== null && this.battery.charging) return 'charging';
    return this.goal !== null ? 'busy' : 'idle';
  }

  /** Return whether it moves at a time. If a motion ends before the path does, the next motion is about to arrive. */
  movesAt(time) {
    if (this._coming.length) this._driveUpTo(time);
    return this.motion !== null && !this.waits && (time < this.motion.ends || this._path.goesOn);
  }

  /** Return the remaining length of the path, without rides in lifts. */
  distanceRemaining(time) {
    return this._path.remaining(this.poseAt(time, scratch));
  }

  /** @returns {number} The end of the last known motion. */
  get ends() {
    return (this._coming.at(-1) ?? this.motion)?.ends ?? -Infinity;
  }

  /** @returns {readonly Point[]} The remaining points of the path; none at rest. */
  get route() {
    return this._path.ahead;
  }

  /** @returns {[number, number, number][]} The driven trail as x, y and time; oldest first, without the current position. */
  get driven() {
    return this._driven.items;
  }

  /** @returns {import('./goals.js').Goal|null} The goal that occupies it, or null. */
  get goal() {
    for (let i = this.goals.length - 1; i >= 0; i -= 1) {
      if (!BESIDE.has(this.goals[i].action)) return this.goals[i];
    }
    return null;
  }

  /** Begin a motion. @param {...Motion} coming The motions after that. */
  begin(motion, ...coming) {
    if (this._coming.length) this._driveUpTo(motion.began);
    this._begin(motion);
    this._coming = coming;
  }

  /** Begin the planned motions that have begun by a time. */
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
    this._path = this._path.on(motion);
  }

  /**
   * Take a path.
   * @param {readonly Point[]} points The points ahead.
   * @param {(a: Point, b: Point) => boolean} rides Whether a lift carries it from one point to the next.
   */
  take(points, rides) {
    // The first path after `makeRoom` leads aside.
    if (!this._makesRoom) this.aside = null;
    this._makesRoom = false;
    this._path = Path.along(points, rides);
  }

  /** Stop. @param {Point} [at] The position, if known. */
  stop(time, at) {
    this.poseAt(time, scratch);
    const [x, y] = at ?? scratch;
    this._stand(time, x, y, scratch[2]);
    this._stay();
    this._drivenTo(x, y, time);
  }

  /** Move to a pose at once. */
  put(time, x, y, yaw) {
    this._track = NOWHERE;
    this._stand(time, x, y, yaw);
    this._stay();
    this._driven.clear();
  }

  /** Stand at the pose of a scene; the driven trail is kept if the pose is the expected one. */
  arrive(time, x, y, yaw) {
    this.poseAt(time, scratch);
    if (!samePlace(scratch, [x, y])) this._driven.clear();
    this._track = NOWHERE;
    this._stand(time, x, y, yaw);
    this._stay();
  }

  /**
   * Stand on the path, blocked.
   * @param {readonly string[]} robots The robots that block it.
   * @param {string} why Another reason.
   * @param {Point} [at] The position, if known.
   */
  wait(time, robots, why, at) {
    this.poseAt(time, scratch);
    const [x, y] = at ?? scratch;
    this._path = this._path.from([x, y]);
    // It faces the next point.
    const next = this._path.ahead[0];
    const faces = next && !samePlace(next, [x, y]);
    this._stand(time, x, y, faces ? Math.atan2(next[1] - y, next[0] - x) : scratch[2]);
    if (!this.waits) this.waitsSince = time;
    this.waits = true;
    this.waitsFor = robots;
    this.waitsWhy = why;
  }

  /** Return the robots that hold it up, by name: those in its way, or in the dock for which it queues. */
  heldBy(model) {
    if (this.waits) return this.waitsFor;
    return (this.queue && model.docks.get(this.queue.dock)?.docked) || NONE;
  }

  /** Move aside for another robot, along the next path of `take`, and wait there. */
  makeRoom(by) {
    this.aside = by;
    this._makesRoom = true;
  }

  goOn() {
    this.waits = false;
    this._settled();
  }

  /** Set or clear a reason for being disabled. @param {string|null} why Null to clear it. */
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

  /** Forget the driven trail. */
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

  /** Clear the path and the reasons for waiting. */
  _stay() {
    this.waits = false;
    this._settled();
    this.queue = this.aside = null;
    this._path = NO_PATH;
  }

  _follow(motion) {
    this._track = motion.after(this._track === NOWHERE ? null : this._track);
  }

  _drivenTo(x, y, time) {
    const last = this._driven.last;
    if (last === undefined || last[0] !== x || last[1] !== y) this._driven.push([x, y, time]);
  }
}

/** Return how many robots are in each state at a time. @returns {Record<string, number>} */
export function countStates(robots, time) {
  const counts = Object.fromEntries(STATES.map((state) => [state, 0]));
  for (const robot of robots.values()) counts[robot.stateAt(time)] += 1;
  return counts;
}

const scratch = [0, 0, 0];
