/** Instants as messages have them. */

/**
 * Return the seconds of a builtin_interfaces/msg/Time or Duration.
 * @param {{sec?: number, nanosec?: number}|null|undefined} stamp
 * @returns {number}
 */
export function secondsOf(stamp) {
  return stamp ? (stamp.sec || 0) + (stamp.nanosec || 0) * 1e-9 : 0;
}
