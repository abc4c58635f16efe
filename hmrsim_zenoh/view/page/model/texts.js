/** Texts for people about events, goals and feedback. Templates of events come with `_world/view`. */

import { secondsOf } from './messages.js';

const PART = /\[([^\]]*)\]|\{[^}]*\}|[^[{]+/g;
const FIELD = /\{(\w+)(?:([:=])([^}]*))?\}/g;

/** Formats by name: each returns a field's text, or "" for a value that counts as missing. */
export const FORMATS = {
  '': plain,
  and: (names) => [names.slice(0, -1).map(plain).join(', '), ...names.slice(-1).map(plain)].filter(Boolean).join(' and '),
  point: ([x, y]) => `(${plain(x)}, ${plain(y)})`,
  end: (points) => (points.length ? FORMATS.point(points[points.length - 1]) : ''),
  percent: (share) => `${Math.round(share * 100)}%`,
  lane: (ends) => ends.join('-'),
  error: ({ error_msg: text, error_code: code, result }) => String(text || code?.message || result?.error_message || ''),
};

/**
 * Fill in a template, which is written as described in hmrsim/events/_text.py.
 * @param {Record<string, (value: any) => string>} [formats] Further formats, or replacements.
 */
export function render(template, event, formats = {}) {
  const known = { ...FORMATS, ...formats };
  return template.replaceAll(PART, (text, optional) => {
    const alternatives = optional === undefined ? [text] : optional.split('|');
    return alternatives.map((each) => filled(each, event, known)).find((said) => said !== null) ?? '';
  });
}

/** Fill in an alternative; null if one of its fields is missing. */
function filled(alternative, event, formats) {
  let given = true;
  const text = alternative.replaceAll(FIELD, (_, name, sign, more) => {
    const value = event[name] ?? null;
    if (sign === '=') {
      given &&= value !== null && plain(value) === more;
      return '';
    }
    const said = value === null ? '' : formats[more ?? '']?.(value) ?? '';
    given &&= said !== '';
    return said;
  });
  return given ? text : null;
}

function plain(value) {
  if (Array.isArray(value)) return value.map(plain).join(', ');
  return typeof value === 'number' ? String(+value.toFixed(2)) : String(value);
}

/**
 * Return the text of an event without its subject: "waits for eve".
 * @param {Record<string, {text: string}>} texts The `events` of `_world/view`.
 * @param {Record<string, (value: any) => string>} [formats] Such as a `point` that knows names.
 */
export function textOf(event, texts, formats) {
  const known = texts[event.kind];
  return (known && render(known.text, event, formats)) || String(event.kind ?? '').replaceAll('_', ' ');
}

/** Return the severity of an event: debug, info, warning or error. */
export function severityOf(event, texts) {
  const known = texts[event.kind];
  return known ? render(known.severity, event) : 'info';
}

/** Return the name of an event's subject; "" for the whole world. */
export function subjectOf(event, texts) {
  const names = texts[event.kind]?.subject ?? ['robot', 'door', 'lift', 'dock', 'entity', 'participant'];
  const value = names.map((name) => event[name]).find((each) => each !== undefined && each !== null) ?? '';
  if (Array.isArray(value)) return FORMATS.lane(value);
  return value === '_world' ? '' : String(value);
}

/**
 * @typedef {{subject: string, text: string, severity: string, group: string}} Description `subject` is "" for the world;
 *   `severity` is debug, info, warning or error.
 */

/**
 * Return the description of an event for people.
 * @param {import('./model.js').Model} model For templates, and names of points.
 */
export function describe(event, { texts, world }) {
  const formats = {
    point: (at) => world.nameAt(at) || FORMATS.point(at),
    goal: (goal) => goalWords(event.action, goal, world),
  };
  return {
    subject: attempt(() => subjectOf(event, texts)),
    text: attempt(() => textOf(event, texts, formats)) || String(event.kind),
    severity: attempt(() => severityOf(event, texts)) || 'info',
    group: texts[event.kind]?.group ?? '',
  };
}

/** Return the request of a goal, such as "to ward_a", or "". */
export function goalWords(action, goal, world) {
  return goal ? attempt(() => REQUESTS.get(action)?.(goal, world)) : '';
}

/** Return the text of a goal's feedback, such as "3.2 left, 4 s", or "". */
export function feedbackWords(feedback, units = '') {
  if (!feedback) return '';
  const parts = [];
  const { distance_remaining: left, estimated_time_remaining: time, number_of_recoveries: recoveries } = feedback;
  if (typeof left === 'number') parts.push(`${number(left)}${units && ` ${units}`} left`);
  const seconds = secondsOf(time ?? feedback.time_left);
  if (seconds > 0) parts.push(`${number(seconds)} s`);
  if (recoveries > 0) parts.push(`${recoveries} ${recoveries === 1 ? 'recovery' : 'recoveries'}`);
  if (typeof feedback.current_waypoint === 'number') parts.push(`waypoint ${feedback.current_waypoint + 1}`);
  if (feedback.number_of_poses_remaining > 0) parts.push(`${feedback.number_of_poses_remaining} poses`);
  if (typeof feedback.distance_traveled === 'number') parts.push(`${number(feedback.distance_traveled)} driven`);
  if (typeof feedback.angular_distance_traveled === 'number') {
    parts.push(`turned by ${number(feedback.angular_distance_traveled)} rad`);
  }
  if (typeof feedback.state === 'string' && feedback.state) parts.push(feedback.state.toLowerCase());
  else if (typeof feedback.state === 'number') parts.push(DOCKING[feedback.state] ?? '');
  return parts.filter(Boolean).join(', ');
}

/** Return a text about a message of others, or "" if the message is invalid. */
function attempt(say) {
  try {
    return String(say() ?? '');
  } catch {
    return '';
  }
}

const DOCKING = ['waiting for a berth', 'to the staging pose', 'docking', 'docking', 'waiting for charge', 'retrying'];

const REQUESTS = new Map(Object.entries({
  navigate_to_pose: ({ pose }, world) => pointWords(pose, world),
  compute_path_to_pose: ({ goal }, world) => pointWords(goal, world),
  compute_path_through_poses: ({ goals }, world) => throughWords(goals?.goals ?? goals, world),
  compute_route: routeWords,
  compute_and_track_route: routeWords,
  smooth_path: ({ path }, world) => pointWords(path?.poses?.[path.poses.length - 1], world),
  navigate_through_poses: ({ poses }, world) => throughWords(poses?.goals ?? poses, world),
  follow_waypoints: ({ poses }, world) => throughWords(poses, world),
  follow_path: ({ path }, world) => pointWords(path?.poses?.[path.poses.length - 1], world),
  spin: ({ target_yaw: yaw }) => `by ${number(yaw ?? 0)} rad`,
  back_up: ({ target }) => `by ${number(Math.abs(target?.x ?? 0))}`,
  drive_on_heading: ({ target }) => `by ${number(target?.x ?? 0)}`,
  dock_robot: ({ dock_id: dock, dock_pose: pose }, world) => (dock ? `at ${dock}` : pointWords(pose, world)),
  wait: ({ time }) => `for ${number(secondsOf(time))} s`,
  pickup: ({ target_name: item }) => item,
  place: ({ attached_object_name: item }) => item,
  simulate_steps: ({ steps }) => `${steps} steps`,
}));

function throughWords(poses, world) {
  if (!Array.isArray(poses) || poses.length === 0) return '';
  const last = pointWords(poses[poses.length - 1], world);
  return poses.length === 1 ? last : `${last}, by ${poses.length} poses`;
}

function routeWords({ use_poses: byPose, goal, goal_id: id }, world) {
  return byPose ? pointWords(goal, world) : `to waypoint ${id ?? 0}`;
}

/** Return the text of a geometry_msgs/msg/PoseStamped. */
function pointWords(stamped, world) {
  const { x = 0, y = 0 } = stamped?.pose?.position ?? stamped?.position ?? {};
  return `to ${named(x, y, world)}`;
}

function named(x, y, world) {
  return world?.nameAt([x, y]) || `(${number(x)}, ${number(y)})`;
}

function number(value) {
  return String(+Number(value).toFixed(Math.abs(value) < 100 ? 2 : 1));
}
