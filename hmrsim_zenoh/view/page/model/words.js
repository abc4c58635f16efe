/** What happens, in a few words for people; as hmrsim/cli/telling.py has them, and of goals, items and faults, too. */

import { ABORTED, CANCELED, errorOf, STATUS, SUCCEEDED } from './goals.js';
import { secondsOf } from './stamps.js';

/** How much an event matters to people. */
export const LEVELS = Object.freeze(['detail', 'info', 'warning', 'error']);

/**
 * Return what an event says, without who it is about (`subjectOf`); never "".
 * @param {Record<string, any>} event
 * @param {import('./world.js').World} [world] For the names of points.
 * @returns {string}
 */
export function words(event, world) {
  return tried(() => WORDS.get(event?.kind)?.(event, world)) || String(event?.kind ?? '').replaceAll('_', ' ');
}

/**
 * Return whom or what an event is about; "" for the whole world.
 * @param {Record<string, any>} event
 * @returns {string}
 */
export function subjectOf(event) {
  if (event.robot === '_world') return '';
  return event.robot ?? event.door ?? event.lift ?? event.entity ?? event.participant ?? '';
}

/**
 * Return how much an event matters: one of `LEVELS`.
 * @param {Record<string, any>} event
 * @returns {string}
 */
export function levelOf(event) {
  if (event.kind === 'status') {
    if (event.status === ABORTED) return 'error';
    return event.status === CANCELED ? 'warning' : event.status === SUCCEEDED ? 'info' : 'detail';
  }
  if (event.kind === 'script_ended') return event.error ? 'error' : 'info';
  return LEVEL.get(event.kind) ?? 'info';
}

/**
 * Return the robots, doors, lifts and lanes that an event names, for whoever wants to go there.
 * @param {Record<string, any>} event
 * @returns {string[]} Names of robots.
 */
export function robotsOf(event) {
  const one = event.robot && event.robot !== '_world' ? [event.robot] : [];
  return [...new Set([...one, ...(event.robots ?? []), ...(event.for ?? []), ...(event.by ? [event.by] : [])])];
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

/** Return words about what somebody else has made up, "" where it is not as it should be. @param {() => any} say */
function tried(say) {
  try {
    return String(say() ?? '');
  } catch {
    return '';
  }
}

const DOCKING = ['waits for a berth', 'to the staging pose', 'drives in', 'drives in', 'waits for charge', 'retries'];

const LEVEL = new Map(Object.entries({
  goal: 'detail', motion: 'detail', route: 'detail', plan_wanted: 'detail', went_on: 'detail', stopped: 'detail',
  door_opening: 'detail', door_opened: 'detail', door_closed: 'detail', lift_called: 'detail',
  lift_departed: 'detail', lift_arrived: 'detail', dock_undocked: 'detail', made_room: 'detail',
  waiting: 'info', rerouted: 'info', lane_closed: 'warning', fault_began: 'warning', fault_missed: 'warning',
  participant_dropped: 'warning', rejected: 'warning', battery_low: 'warning', battery_critical: 'warning',
  dropped: 'warning', deadlock: 'error', battery_empty: 'error',
}));

const SIMULATION_STATES = ['stopped', 'plays', 'paused'];

const WORDS = new Map(Object.entries({
  status({ action, status, result }) {
    const [code, text] = status === ABORTED || status === CANCELED ? errorOf(result) : [null, ''];
    const why = [code === null ? '' : `code ${code}`, text].filter(Boolean).join(', ');
    return `${action} ${STATUS[status] ?? status}${why && `: ${why}`}`;
  },
  goal: ({ action, goal }, world) => `is asked for ${[action, goalWords(action, goal, world)].filter(Boolean).join(' ')}`,
  rejected: ({ action, reason, error_msg: text }) => `${action} rejected, ${reason}${text ? `: ${text}` : ''}`,
  stopped: ({ at }, world) => `stops${spot(at, world, ' at ')}`,
  picked: ({ item }) => `picks up ${item}`,
  placed: ({ item, at }, world) => `lays down ${item}${spot(at, world, ' at ')}`,
  dropped: ({ item, at }, world) => `drops ${item}${spot(at, world, ' at ')}`,
  waiting: (event) => (event.why ? `waits: ${event.why}` : `waits for ${(event.for ?? []).join(' and ') || 'its turn'}`),
  went_on: ({ waited }) => `goes on${waited > 0 ? ` after ${number(waited)} s` : ''}`,
  rerouted: () => 'takes another way',
  made_room: ({ by }) => `makes room for ${by}`,
  deadlock: ({ robots }) => `deadlock of ${(robots ?? []).join(', ')}`,
  lane_closed: ({ lane, why }) => `${laneWords(lane)} is closed${why ? `: ${why}` : ''}`,
  lane_opened: ({ lane }) => `${laneWords(lane)} is open again`,
  fault_began: ({ name, fault }) => `${name} begins (${fault})`,
  fault_ended: ({ name }) => `${name} is over`,
  fault_missed: ({ name, why }) => `${name} could not happen: ${why}`,
  dock_queued: ({ dock, position }) => `queues for ${dock}, as number ${position}`,
  dock_docked: ({ dock }) => `docked at ${dock}`,
  dock_undocked: ({ dock }) => `left ${dock}`,
  battery_low: (event) => `battery low, ${share(event)}`,
  battery_critical: (event) => `battery critical, ${share(event)}`,
  battery_empty: () => 'battery empty',
  battery_revived: (event) => `can go on again, ${share(event)}`,
  battery_full: () => 'battery full',
  charging_began: (event) => `charges, ${share(event)}`,
  charging_ended: (event) => `charges no more, ${share(event)}`,
  door_opening: ({ by }) => `opens${by ? ` for ${by}` : ''}`,
  door_opened: ({ by }) => `is open${by ? ` for ${by}` : ''}`,
  door_closed: () => 'is closed',
  lift_called: ({ stop, by }) => `is called to ${stop}${by ? ` by ${by}` : ''}`,
  lift_departed: ({ from, to, robots }) => {
    return `goes from ${from} to ${to}${robots?.length ? ` with ${robots.join(', ')}` : ', empty'}`;
  },
  lift_arrived: ({ stop }) => `is at ${stop}`,
  spawned: ({ type, at }, world) => `is there, ${type}${spot(at, world, ' at ')}`,
  deleted: () => 'is gone',
  teleported: ({ at }, world) => `was put somewhere else${spot(at, world, ', to ')}`,
  script_ended: ({ done, orders, error }) => error || `script carried out, ${done} of ${orders} orders`,
  participant_joined: () => 'takes part in lockstep',
  participant_left: () => 'takes part in lockstep no more',
  participant_dropped: ({ why }) => `dropped from lockstep${why ? `: ${why}` : ''}`,
  planner: ({ present }) => (present ? 'a planner is there' : 'the planner is gone'),
  plan_wanted: ({ request }) => `wants a path from the planner, request ${request}`,
  simulation_state: ({ state }) => `simulation ${SIMULATION_STATES[state] ?? `in state ${state}`}`,
  reset: () => 'the simulation was reset',
  world_loaded: ({ name }) => `world ${name} was loaded`,
  motion: ({ to, turned }, world) => (turned === undefined ? `drives${spot(to, world, ' to ')}` : 'turns'),
  route: ({ points }, world) => `takes a way${spot(points?.at(-1), world, ' to ')}`,
}));

const ASKED = new Map(Object.entries({
  navigate_to_pose: ({ pose }, world) => pointWords(pose, world),
  compute_path_to_pose: ({ goal }, world) => pointWords(goal, world),
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

function laneWords(lane) {
  return lane?.join('-') ?? 'a lane';
}

function throughWords(poses, world) {
  if (!Array.isArray(poses) || poses.length === 0) return '';
  const last = pointWords(poses[poses.length - 1], world);
  return poses.length === 1 ? last : `${last}, by ${poses.length} poses`;
}

/** Return where a geometry_msgs/msg/PoseStamped is. */
function pointWords(stamped, world) {
  const { x = 0, y = 0 } = stamped?.pose?.position ?? stamped?.position ?? {};
  return `to ${named(x, y, world)}`;
}

function spot(at, world, before) {
  return Array.isArray(at) ? before + named(at[0], at[1], world) : '';
}

function named(x, y, world) {
  return world?.nameAt([x, y]) || `(${number(x)}, ${number(y)})`;
}

function share({ percentage }) {
  return `${Math.round((percentage ?? 0) * 100)}%`;
}

function number(value) {
  return String(+Number(value).toFixed(Math.abs(value) < 100 ? 2 : 1));
}
