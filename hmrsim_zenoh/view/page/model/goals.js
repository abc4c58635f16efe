/** Goals of actions. */

/** Statuses of a goal, as in action_msgs/msg/GoalStatus. */
export const ACCEPTED = 1;
const SUCCEEDED = 4;
export const ABORTED = 6;

const MAX_GOALS = 2000;
const FORGOTTEN = 200;
const MOVEIT_SUCCESS = 1;

/**
 * @typedef {typeof UNKNOWN} Goal Immutable. `key` is the id, with robot and action if another robot's goal has the same id;
 *   `goal`, `result` and `feedback` are the action's messages; `status` is as in action_msgs/msg/GoalStatus; `accepted` and
 *   `ended` are simulated seconds; `errorCode` is null without an error. What is unknown is null.
 */
const UNKNOWN = {
  key: '', id: '', robot: '', action: '', goal: null, status: 0, accepted: null, ended: null, result: null, errorCode: null,
  errorMsg: '', feedback: null,
};

/** Return whether a status is that of an active goal. */
export function isActive(status) { return status >= ACCEPTED && status < SUCCEEDED; }

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

/** All known goals by key, in order of acceptance. */
export class Goals extends Map {
  /** @returns {Goal|undefined} */
  find(robot, action, id) {
    const found = this.get(id);
    return !found || (found.robot === robot && found.action === action) ? found : this.get(`${id} ${robot}/${action}`);
  }

  /** Add a goal, or change some of its values. @returns {Goal} */
  change(robot, action, id, more) {
    const goal = { ...(this.find(robot, action, id) ?? this._new(robot, action, id)), ...more };
    this.set(goal.key, goal);
    return goal;
  }

  _new(robot, action, id) {
    if (this.size >= MAX_GOALS) this._forget();
    return { ...UNKNOWN, key: this.has(id) ? `${id} ${robot}/${action}` : id, id, robot, action };
  }

  /** Forget the oldest ended goals, many at once; if none has ended, the oldest of all. */
  _forget() {
    const all = [...this.values()];
    const ended = all.filter(({ status }) => !isActive(status));
    for (const { key } of (ended.length ? ended : all).slice(0, FORGOTTEN)) this.delete(key);
  }
}
