// Texts about robots' states, and times and numbers for people.

import { goalWords } from '../model/texts.js';

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

/** Return a share as 87 %. @param {number} share From 0 to 1. */
export function shareWords(share) {
  return `${Math.round(share * 100)} %`;
}

/** Return a number with four digits. */
export function numberWords(value) {
  return String(+value.toPrecision(4));
}

/** Return a name in words: navigate to pose. */
export function actionWords(name) {
  return name.replaceAll('_', ' ');
}

/** Return a name as a title: Navigate to pose. */
export function inWords(name) {
  return name.charAt(0).toUpperCase() + actionWords(name.slice(1));
}

/** The verbs of actions that are followed by a destination. */
const VERBS = { navigate_to_pose: 'go', navigate_through_poses: 'go', dock_robot: 'dock', drive_on_heading: 'drive' };

/** Return a goal in one line: go to ward_a. */
export function taskWords({ action, goal }, world) {
  const asked = goalWords(action, goal, world);
  return [(asked && VERBS[action]) || actionWords(action), asked].filter(Boolean).join(' ');
}

/**
 * Return the reason for a robot's state, to follow the word for the state; "" for none.
 * @param {string} state One of `STATES`.
 */
export function whyWords(robot, state, model, now) {
  const said = REASONS[state]?.(robot, model, now) ?? '';
  const script = robot.script?.error ? `script: ${robot.script.error}` : '';
  return said || script;
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
    const since = robot.waitsSince === null ? '' : `, ${lastingWords(Math.max(0, now - robot.waitsSince))}`;
    if (robot.waitsFor.length) return `for ${robot.waitsFor.join(' and ')}${where(robot, model, now)}${since}`;
    if (robot.waitsWhy) return `because ${robot.waitsWhy}${since}`;
    if (robot.aside) return `aside, to let ${robot.aside} pass`;
    return `for its turn${where(robot, model, now)}${since}`;
  },
  charging: (robot) => (robot.dock ? `at ${robot.dock}` : ''),
  busy: (robot) => (robot.queue ? `number ${robot.queue.position} in the queue for ${robot.queue.dock}` : ''),
  idle: (robot) => (robot.dock ? `docked at ${robot.dock}` : ''),
};

function where(robot, model, now) {
  const name = model.world.nameAt(robot.poseAt(now));
  return name ? ` at ${name}` : '';
}
