/** Goals of actions. */

/**
 * @typedef {object} Goal Immutable.
 * @property {string} key Its id, with robot and action if another robot's goal has the same id.
 * @property {string} id
 * @property {string} robot
 * @property {string} action
 * @property {object|null} goal The action's goal message; null if unknown.
 * @property {number} status As in action_msgs/msg/GoalStatus.
 * @property {number|null} accepted Simulated seconds.
 * @property {number|null} ended
 * @property {object|null} result
 * @property {number|null} errorCode The code of an error; null for none.
 * @property {string} errorMsg The text of an error, or "".
 * @property {object|null} feedback The latest feedback.
 */

/** Statuses of a goal, as in action_msgs/msg/GoalStatus. */
export const ACCEPTED = 1;
const SUCCEEDED = 4;
export const ABORTED = 6;

const MAX_GOALS = 2000;
const FORGOTTEN = 200;
const MOVEIT_SUCCESS = 1;

/** Return whether a status is that of an active goal. */
export function isActive(status) {
  return status >= ACCEPTED && status < SUCCEEDED;
}

/**
 * Return the error of a result, in the fields of Nav2, MoveIt or simulation_interfaces.
 * @returns {[number|null, string]} The code, or null, and the text.
 */
export function errorOf(result) {
  const code = result?.error_code;
  if (code !== null && typeof code === 'object') {
    return [code.val && code.val !== MOVEIT_SUCCESS ? code.val : null, String(code.message ?? '')];
  }
  return [code || null, String(result?.error_msg || result?.result?.error_message || '')];
}

/** All known goals, in order of acceptance. */
export class Goals {
  constructor() {
    this.all = new Map();
  }

  /** Return a goal, or undefined. */
  find(robot, action, id) {
    const found = this.all.get(id);
    if (found === undefined || (found.robot === robot && found.action === action)) return found;
    return this.all.get(longKey(robot, action, id));
  }

  /** Add a goal, or change some of its values. */
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

  /** Forget the oldest ended goals, many at once; if none has ended, the oldest of all. */
  _forget() {
    const oldest = [...this.all.values()].filter((goal) => !isActive(goal.status)).slice(0, FORGOTTEN);
    for (const { key } of oldest.length ? oldest : [...this.all.values()].slice(0, FORGOTTEN)) this.all.delete(key);
  }
}

function longKey(robot, action, id) {
  return `${id} ${robot}/${action}`;
}
