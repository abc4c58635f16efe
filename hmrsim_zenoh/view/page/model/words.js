/** What events, goals and feedback say, in a few words for people; templates of events come with `_world/view`. */

import { FORMATS, severityOf, subjectOf, textOf } from './event_text.js';
import { secondsOf } from './stamps.js';

/**
 * @typedef {{subject: string, text: string, severity: string, group: string}} Told `subject` is "" for the whole world;
 *   `severity` is debug, info, warning or error.
 */

/**
 * Return what people are told of an event.
 * @param {Record<string, any>} event
 * @param {import('./model.js').Model} model For templates, and names of points.
 * @returns {Told}
 */
export function told(event, { texts, world }) {
  const formats = {
    point: (at) => world.nameAt(at) || FORMATS.point(at),
    goal: (goal) => goalWords(event.action, goal, world),
  };
  return {
    subject: tried(() => subjectOf(event, texts)),
    text: tried(() => textOf(event, texts, formats)) || String(event.kind),
    severity: tried(() => severityOf(event, texts)) || 'info',
    group: texts[event.kind]?.group ?? '',
  };
}

/**
 * Return what a goal asks for, such as "to ward_a".
 * @param {string} action
 * @param {object|null} goal
 * @param {import('./world.js').World} [world]
 * @returns {string} Or "".
 */
export function goalWords(action, goal, world) {
  return goal ? tried(() => ASKED.get(action)?.(goal, world)) : '';
}

/**
 * Return what the feedback of a goal says, such as "3.2 left, 4 s".
 * @param {object|null} feedback
 * @param {string} [units]
 * @returns {string} Or "".
 */
export function feedbackWords(feedback, units = '') {
  if (!feedback) return '';
  const said = [];
  const { distance_remaining: left, estimated_time_remaining: time, number_of_recoveries: recoveries } = feedback;
  if (typeof left === 'number') said.push(`${number(left)}${units && ` ${units}`} left`);
  const seconds = secondsOf(time ?? feedback.time_left);
  if (seconds > 0) said.push(`${number(seconds)} s`);
  if (recoveries > 0) said.push(`${recoveries} ${recoveries === 1 ? 'recovery' : 'recoveries'}`);
  if (typeof feedback.current_waypoint === 'number') said.push(`waypoint ${feedback.current_waypoint + 1}`);
  if (feedback.number_of_poses_remaining > 0) said.push(`${feedback.number_of_poses_remaining} poses`);
  if (typeof feedback.distance_traveled === 'number') said.push(`${number(feedback.distance_traveled)} driven`);
  if (typeof feedback.angular_distance_traveled === 'number') {
    said.push(`turned by ${number(feedback.angular_distance_traveled)} rad`);
  }
  if (typeof feedback.state === 'string' && feedback.state) said.push(feedback.state.toLowerCase());
  else if (typeof feedback.state === 'number') said.push(DOCKING[feedback.state] ?? '');
  return said.filter(Boolean).join(', ');
}

/** Return words about what others have made up, "" where it is not as it should be. @param {() => any} say */
function tried(say) {
  try {
    return String(say() ?? '');
  } catch {
    return '';
  }
}

const DOCKING = ['waiting for a berth', 'to the staging pose', 'docking', 'docking', 'waiting for charge', 'retrying'];

const ASKED = new Map(Object.entries({
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

/** Return where a geometry_msgs/msg/PoseStamped is. */
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
