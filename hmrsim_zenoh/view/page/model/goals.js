/** Goals of actions, as the table of goals has them. */

/**
 * @typedef {object} Goal It is never changed: another takes its place.
 * @property {string} key Its id; with robot and action where another robot has a goal of that id, too.
 * @property {string} id
 * @property {string} robot
 * @property {string} action
 * @property {object|null} goal What was asked for, as the message of the action; null if that is not known.
 * @property {number} status As in action_msgs/msg/GoalStatus.
 * @property {number|null} accepted When, in simulated seconds.
 * @property {number|null} ended
 * @property {object|null} result
 * @property {number|null} errorCode What a result that is an error has; null for none.
 * @property {string} errorMsg Or "".
 * @property {object|null} feedback The last that was received.
 */

/** Statuses of a goal, as in action_msgs/msg/GoalStatus. */
export const ACCEPTED = 1;
const SUCCEEDED = 4;
export const ABORTED = 6;

const MAX_GOALS = 2000;
const FORGOTTEN = 200;
const MOVEIT_SUCCESS = 1;

/** Return whether a goal of this status goes on. */
export function isActive(status) {
  return status >= ACCEPTED && status < SUCCEEDED;
}

/**
 * Return what a result says of an error, in the fields of Nav2, MoveIt or the simulation.
 * @returns {[number|null, string]} The code, or null, and the text.
 */
export function errorOf(result) {
  const code = result?.error_code;
  if (code !== null && typeof code === 'object') {
    return [code.val && code.val !== MOVEIT_SUCCESS ? code.val : null, String(code.message ?? '')];
  }
  return [code || null, String(result?.error_msg || result?.result?.error_message || '')];
}

/** All goals that are known, in order of acceptance. */
export class Goals {
  constructor() {
    /** @type {Map<string, Goal>} */
    this.all = new Map();
  }

  /** Return a goal, or undefined. */
  find(robot, action, id) {
    const found = this.all.get(id);
    if (found === undefined || (found.robot === robot && found.action === action)) return found;
    return this.all.get(longKey(robot, action, id));
  }

  /** Know of a goal, or know more of it. */
  set(robot, action, id, more) {
    const known = this.find(robot, action, id) ?? this._new(robot, action, id);
    const goal = { ...known, ...more };
    this.all.set(goal.key, goal);
    return goal;
  }

  saved() {
    return new Map(this.all);
  }

  restore(saved) {
    this.all.clear();
    for (const [key, goal] of saved) this.all.set(key, goal);
  }

  _new(robot, action, id) {
    if (this.all.size >= MAX_GOALS) this._forget();
    const key = this.all.has(id) ? longKey(robot, action, id) : id;
    return {
      key, id, robot, action, goal: null, status: 0, accepted: null, ended: null, result: null,
      errorCode: null, errorMsg: '', feedback: null,
    };
  }

  /** Forget the oldest that have ended, many at once; where none has, the oldest of all. */
  _forget() {
    const oldest = [...this.all.values()].filter((goal) => !isActive(goal.status)).slice(0, FORGOTTEN);
    for (const { key } of oldest.length ? oldest : [...this.all.values()].slice(0, FORGOTTEN)) this.all.delete(key);
  }
}

function longKey(robot, action, id) {
  return `${id} ${robot}/${action}`;
}
