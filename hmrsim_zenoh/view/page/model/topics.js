/** Numbers in the messages of topics. */

import { secondsOf } from './messages.js';

const MAX_ITEMS = 8; // items of a list, beyond which it is data rather than values
const MAX_DEPTH = 8;
const SKIPPED = new Set(['stamp', 'header']);

/** Return the dotted paths of all numbers in a message, such as "pose.pose.position.x". */
export function numbersIn(message, path = [], depth = 0) {
  if (Number.isFinite(message)) return [path.join('.')];
  if (typeof message !== 'object' || message === null || depth > MAX_DEPTH) return [];
  const parts = Object.entries(message);
  if (Array.isArray(message) && parts.length > MAX_ITEMS) return [];
  return parts.flatMap(([name, part]) => (SKIPPED.has(name) ? [] : numbersIn(part, [...path, name], depth + 1)));
}

/** Return the number at a path of a message; undefined if there is none. */
export function numberAt(message, path) {
  const value = path.split('.').reduce((part, name) => (part !== null && typeof part === 'object' && Object.hasOwn(part, name) ? part[name] : undefined), message);
  return Number.isFinite(value) ? value : undefined;
}

/** Return the time of a message in simulated seconds; undefined if it has none. */
export function timeIn(message) {
  const stamp = message?.header?.stamp ?? message?.stamp;
  return Number.isFinite(stamp?.sec) ? secondsOf(stamp) : undefined;
}
