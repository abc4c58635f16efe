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
 */
export class Robot {
  constructor(name, type = '') {
    this.name = name;
    this.type = type;
    this.radius = 0; // the radius of the footprint; 0 for none
    this.flies = false;
    this.connected = true; // whether messages from it arrive
    this.motion = null; // the current or latest motion; null after a stop, and while it waits
    this.waiting = null; // the time `since` which it is blocked on its path, and `why`, or `for` which robots
    this.queue = null; // its place in a dock's queue, and the goal
    this.aside = null; // the robot that it has let pass and still waits for
    this._makesRoom = false;
    this.dock = null; // the dock where it is docked
    this.holds = NONE; // the items that it carries
    this.ailments = WELL; // the reasons for which it is disabled, by cause
    this.battery = null; // the percentage, from 0 to 1, and whether it is charging
    this.sensors = NONE; // name, range, field_of_view and blind of each
    this.detections = NONE; // the latest detections: id, and at: x, y, yaw
    this.goals = NONE; // its active goals, in order of acceptance
    this.scriptError = ''; // why its script has failed
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
    if (this.waiting !== null) return 'waiting';
    if (this.movesAt(time)) return 'driving';
    if (this.aside !== null && this.goal !== null) return 'waiting';
    if (this.battery !== null && this.battery.charging) return 'charging';
    return this.goal !== null ? 'busy' : 'idle';
  }

  /** Return whether it moves at a time. If a motion ends before the path does, the next motion is about to arrive. */
  movesAt(time) {
    if (this._coming.length) this._driveUpTo(time);
    return this.motion !== null && this.waiting === null && (time < this.motion.ends || this._path.goesOn);
  }

  /** Return the remaining length of the path, without rides in lifts. */
  distanceRemaining(time) { return this._path.remaining(this.poseAt(time)); }

  /** @returns {number} The end of the last known motion. */
  get ends() { return (this._coming.at(-1) ?? this.motion)?.ends ?? -Infinity; }

  /** @returns {readonly Point[]} The remaining points of the path; none at rest. */
  get route() { return this._path.ahead; }

  /** @returns {[number, number, number][]} The driven trail as x, y and time; oldest first, without the current position. */
  get driven() { return this._driven.items; }

  /** @returns {import('./goals.js').Goal|null} The goal that occupies it, or null. */
  get goal() { return this.goals.findLast(({ action }) => !BESIDE.has(action)) ?? null; }

  /** Begin a motion. @param {...Motion} coming The motions after that. */
  begin(motion, ...coming) {
    if (this._coming.length) this._driveUpTo(motion.began);
    this._begin(motion);
    this._coming = coming;
  }

  /** Begin the planned motions that have begun by a time. */
  _driveUpTo(time) {
    const coming = this._coming;
    let begun = 0;
    while (begun < coming.length && coming[begun].began <= time) this._begin(coming[begun++]);
    if (begun) this._coming = coming.slice(begun);
  }

  _begin(motion) {
    this._follow(motion);
    this.motion = motion;
    this.waiting = this.queue = null;
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
  stop(time, at = undefined) {
    const pose = this.poseAt(time);
    const [x, y] = at ?? pose;
    this._stay(time, [x, y, pose[2]]);
    this._drivenTo(x, y, time);
  }

  /** Put it at a pose. @param {boolean} [expected] Whether to keep the driven trail if it is there already. */
  put(time, x, y, yaw, expected = false) {
    if (!expected || !samePlace(this.poseAt(time), [x, y])) this._driven.clear();
    this._track = NOWHERE;
    this._stay(time, [x, y, yaw]);
  }

  /**
   * Stand on the path, blocked.
   * @param {{for?: string[], why?: string, at?: Point}} cause The robots that block it, or another reason, and the position.
   */
  wait(time, { for: robots = NONE, why = '', at }) {
    const pose = this.poseAt(time);
    const [x, y] = at ?? pose;
    this._path = this._path.from([x, y]);
    // It faces the next point.
    const next = this._path.ahead[0];
    const faces = next && !samePlace(next, [x, y]);
    this._stand(time, [x, y, faces ? Math.atan2(next[1] - y, next[0] - x) : pose[2]]);
    this.waiting = { since: this.waiting?.since ?? time, for: robots ?? NONE, why };
  }

  /** Return the robots that hold it up, by name: those in its way, or in the dock for which it queues. */
  heldBy(model) { return this.waiting?.for ?? (this.queue && model.docks.get(this.queue.dock)?.docked) ?? NONE; }

  /** Move aside for another robot, along the next path of `take`, and wait there. */
  makeRoom(by) {
    this.aside = by;
    this._makesRoom = true;
  }

  /** Set or clear a reason for being disabled. @param {string|null} why Null to clear it. */
  disable(what, why) {
    const { [what]: _, ...others } = this.ailments;
    this.setAilments(why === null ? others : { ...others, [what]: why });
  }

  setAilments(ailments) { this.ailments = Object.keys(ailments).length ? ailments : WELL; }

  /** @returns {object} What `restore` takes. */
  saved() { return { ...this, _driven: this._driven.copy() }; }

  restore(saved) { Object.assign(this, saved, { _driven: saved._driven.copy() }); }

  /** Forget the driven trail. */
  forgetDriven() { this._driven.clear(); }

  /** Stand still from a time on. */
  _stand(time, at) {
    this._coming = NONE;
    this._follow(new Motion({ from: at, to: at }, time));
    this.motion = null;
  }

  /** Stand still, without a path and reasons for waiting. */
  _stay(time, at) {
    this._stand(time, at);
    this.waiting = this.queue = this.aside = null;
    this._path = NO_PATH;
  }

  _follow(motion) { this._track = motion.after(this._track === NOWHERE ? null : this._track); }

  _drivenTo(x, y, time) {
    const { last } = this._driven;
    if (last === undefined || last[0] !== x || last[1] !== y) this._driven.push([x, y, time]);
  }
}

/** Return how many robots are in each state at a time. @returns {Record<string, number>} */
export function countStates(robots, time) {
  const counts = Object.fromEntries(STATES.map((state) => [state, 0]));
  for (const robot of robots.values()) counts[robot.stateAt(time)] += 1;
  return counts;
}
