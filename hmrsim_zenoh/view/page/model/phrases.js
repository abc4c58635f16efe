// Texts for people about robots' states, goals, times and numbers.

import { secondsOf } from './messages.js';

/** The word for each status of a goal, by number. */
export const STATUS_WORDS = ['unknown', 'accepted', 'executing', 'canceling', 'succeeded', 'canceled', 'aborted'];

/** Return simulated seconds as 1:02:03.4, without hours if there are none. @param {number} [digits] Digits after the point. */
export function clockWords(seconds, digits = 0) {
  const unit = 10 ** digits;
  const whole = Math.floor(Math.max(0, seconds) * unit + 1e-6) / unit;
  const [hours, minutes] = [Math.floor(whole / 3600), Math.floor(whole / 60) % 60];
  const rest = (whole % 60).toFixed(digits).padStart(digits ? digits + 3 : 2, '0');
  return hours ? `${hours}:${String(minutes).padStart(2, '0')}:${rest}` : `${minutes}:${rest}`;
}

/** Return a duration: 4.2 s, 3 min 20 s, 2 h 5 min. */
export function lastingWords(seconds) {
  if (seconds < 9.95) return `${seconds.toFixed(1)} s`;
  const whole = Math.round(seconds);
  if (whole < 60) return `${whole} s`;
  if (whole < 3600) return `${Math.floor(whole / 60)} min ${whole % 60} s`;
  return `${Math.floor(whole / 3600)} h ${Math.floor(whole / 60) % 60} min`;
}

/** Return a length with its unit. */
export function lengthWords(length, units) {
  return units === 'px' ? `${Math.round(length)} px` : `${length.toFixed(1)} m`;
}

/** Return a point as 1.5, 2.0; in pixels as whole numbers. */
export function pointWords(point, units) {
  return point.map((each) => each.toFixed(units === 'px' ? 0 : 1)).join(', ');
}

/** Return a share as 87 %. @param {number} share From 0 to 1. */
export function shareWords(share) { return `${Math.round(share * 100)} %`; }

/** Return a number with four digits. */
export function numberWords(value) { return String(+value.toPrecision(4)); }

/** Return a name in words: navigate to pose. */
export function actionWords(name) { return name.replaceAll('_', ' '); }

/** Return a name as a title: Navigate to pose. */
export function inWords(name) { return name.charAt(0).toUpperCase() + actionWords(name.slice(1)); }

/** The verbs of actions that are followed by a destination. */
const VERBS = { navigate_to_pose: 'go', navigate_through_poses: 'go', dock_robot: 'dock', drive_on_heading: 'drive' };

/** Return a goal in one line: go to ward_a. */
export function taskWords({ action, goal }, world) {
  const asked = goalWords(action, goal, world);
  return [(asked && VERBS[action]) || actionWords(action), asked].filter(Boolean).join(' ');
}

const REQUESTS = new Map(Object.entries({
  navigate_to_pose: ({ pose }, world) => toPose(pose, world),
  compute_path_to_pose: ({ goal }, world) => toPose(goal, world),
  compute_path_through_poses: ({ goals }, world) => through(goals?.goals ?? goals, world),
  compute_route: alongRoute,
  compute_and_track_route: alongRoute,
  smooth_path: ({ path }, world) => toPose(path?.poses?.at(-1), world),
  navigate_through_poses: ({ poses }, world) => through(poses?.goals ?? poses, world),
  follow_waypoints: ({ poses }, world) => through(poses, world),
  follow_path: ({ path }, world) => toPose(path?.poses?.at(-1), world),
  spin: ({ target_yaw: yaw }) => `by ${number(yaw ?? 0)} rad`,
  back_up: ({ target }) => `by ${number(Math.abs(target?.x ?? 0))}`,
  drive_on_heading: ({ target }) => `by ${number(target?.x ?? 0)}`,
  dock_robot: ({ dock_id: dock, dock_pose: pose }, world) => (dock ? `at ${dock}` : toPose(pose, world)),
  wait: ({ time }) => `for ${number(secondsOf(time))} s`,
  pickup: ({ target_name: item }) => item,
  place: ({ attached_object_name: item }) => item,
  simulate_steps: ({ steps }) => `${steps} steps`,
}));

/** Return the request of a goal, such as "to ward_a", or "". */
export function goalWords(action, goal, world) {
  return goal ? attempt(() => REQUESTS.get(action)?.(goal, world)) : '';
}

/** Return a text about a message of others, or "" if the message is invalid. */
export function attempt(say) {
  try {
    return String(say() ?? '');
  } catch {
    return '';
  }
}

function through(poses, world) {
  if (!Array.isArray(poses) || poses.length === 0) return '';
  const last = toPose(poses.at(-1), world);
  return poses.length === 1 ? last : `${last}, by ${poses.length} poses`;
}

function alongRoute({ use_poses: byPose, goal, goal_id: id }, world) {
  return byPose ? toPose(goal, world) : `to waypoint ${id ?? 0}`;
}

/** Return the text of a geometry_msgs/msg/PoseStamped. */
function toPose(stamped, world) {
  const { x = 0, y = 0 } = stamped?.pose?.position ?? stamped?.position ?? {};
  return `to ${world?.nameAt([x, y]) || `(${number(x)}, ${number(y)})`}`;
}

function number(value) { return String(+Number(value).toFixed(Math.abs(value) < 100 ? 2 : 1)); }

const DOCKING = ['waiting for a berth', 'to the staging pose', 'docking', 'docking', 'waiting for charge', 'retrying'];

/** Return the text of a goal's feedback, such as "3.2 left, 4 s", or "". */
export function feedbackWords(feedback, units = '') {
  if (!feedback) return '';
  const { distance_remaining: left, number_of_recoveries: recoveries, number_of_poses_remaining: poses, state } = feedback;
  const seconds = secondsOf(feedback.estimated_time_remaining ?? feedback.time_left);
  const some = (value, words) => (typeof value === 'number' ? words(value) : '');
  return [
    some(left, () => `${number(left)}${units && ` ${units}`} left`),
    seconds > 0 ? `${number(seconds)} s` : '',
    recoveries > 0 ? `${recoveries} ${recoveries === 1 ? 'recovery' : 'recoveries'}` : '',
    some(feedback.current_waypoint, (index) => `waypoint ${index + 1}`),
    poses > 0 ? `${poses} poses` : '',
    some(feedback.distance_traveled, (length) => `${number(length)} driven`),
    some(feedback.angular_distance_traveled, (angle) => `turned by ${number(angle)} rad`),
    typeof state === 'string' ? state.toLowerCase() : DOCKING[state],
  ].filter(Boolean).join(', ');
}

/**
 * Return the reason for a robot's state, to follow the word for the state; "" for none.
 * @param {string} state One of `STATES`.
 */
export function whyWords(robot, state, model, now) {
  return REASONS[state]?.(robot, model, now) || (robot.scriptError && `script: ${robot.scriptError}`);
}

/** Return the active faults of a robot, such as "wheel slip"; "" for none. */
export function faultWords({ name: robot }, { faults }) {
  return Array.from(faults.values()).filter((fault) => fault.robot === robot)
    .map(({ name, fault }) => (name.startsWith(fault) ? actionWords(fault) : `${name} (${actionWords(fault)})`)).join(', ');
}

const MOST_CAUSES = 5;

/**
 * Return the chain of causes for which a robot does not go on: each robot that holds up the one before it, with its
 * state, down to the first one that nothing holds up; "" if no robot holds it up.
 */
export function causeWords(robot, model, now) {
  const seen = new Set([robot]);
  const words = [];
  for (let each = nextCause(robot, model, now); each; each = nextCause(each, model, now)) {
    if (seen.has(each)) return `${words.join('; ')}: they wait for each other in a circle`;
    seen.add(each);
    if (words.length === MOST_CAUSES) return `${words.join('; ')}; …`;
    const state = each.stateAt(now);
    const why = whyWords(each, state, model, now);
    const at = why ? '' : where(each, model, now);
    words.push(`${each.name}: ${[state, why].filter(Boolean).join(' ')}${at}`);
  }
  return words.join('; ');
}

/** Return the first robot by name that holds up another one and does not just drive on, or else the first one. */
function nextCause(robot, model, now) {
  const others = robot.heldBy(model).map((name) => model.robots.get(name)).filter(Boolean);
  return others.find((each) => !each.movesAt(now)) ?? others[0];
}

const REASONS = {
  offline: (robot) => `no connection to ${robot.name}: nothing that it publishes arrives`,
  stopped: (robot) => Object.values(robot.ailments).join('; '),
  waiting(robot, model, now) {
    const { since = now, for: others = [], why = '' } = robot.waiting ?? {};
    const lasting = robot.waiting ? `, ${lastingWords(Math.max(0, now - since))}` : '';
    if (others.length) return `for ${others.join(' and ')}${where(robot, model, now)}${lasting}`;
    if (why) return `because ${why}${lasting}`;
    return robot.aside ? `aside, to let ${robot.aside} pass` : `for its turn${where(robot, model, now)}${lasting}`;
  },
  charging: (robot) => (robot.dock ? `at ${robot.dock}` : ''),
  busy: (robot) => (robot.queue ? `number ${robot.queue.position} in the queue for ${robot.queue.dock}` : ''),
  idle: (robot) => (robot.dock ? `docked at ${robot.dock}` : ''),
};

function where(robot, model, now) {
  const name = model.world.nameAt(robot.poseAt(now));
  return name ? ` at ${name}` : '';
}
