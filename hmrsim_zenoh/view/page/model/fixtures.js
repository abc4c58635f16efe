/** Docks, doors and lifts as they are now. What is said of one is replaced and never changed. */

/**
 * @typedef {import('./motion.js').Point} Point
 * @typedef {import('./world.js').DoorSpec & {state: 'open'|'opening'|'closed', locked: boolean, jammed: boolean}} Door
 *
 * @typedef {object} LiftState
 * @property {string} stop Where its cabin is; while it moves the stop that it has left.
 * @property {Point} at Where that is.
 * @property {string|null} to The one to which it moves.
 * @property {number|null} departed
 * @property {number|null} arrives
 * @property {string[]} carries Robots.
 * @typedef {import('./world.js').LiftSpec & LiftState} Lift
 *
 * @typedef {import('./world.js').DockSpec & {docked: string[], queue: string[]}} Dock The robots in it, and those that
 *   wait for a berth, in order.
 */

/** Return a door as it is in the beginning. @param {import('./world.js').DoorSpec} spec @returns {Door} */
export function newDoor(spec) {
  return { ...spec, state: spec.open ? 'open' : 'closed', locked: false, jammed: false };
}

/** Return a lift as it is in the beginning. @param {import('./world.js').LiftSpec} spec @returns {Lift} */
export function newLift(spec) {
  return moved({ ...spec, to: null, departed: null, arrives: null, carries: [] }, { stop: spec.at });
}

/** Return a dock as it is in the beginning. @param {import('./world.js').DockSpec} spec @returns {Dock} */
export function newDock(spec) {
  return { ...spec, docked: [], queue: [] };
}

/** Return a lift of which more is known. @param {Lift} lift @param {Partial<Lift>} more @returns {Lift} */
export function moved(lift, more) {
  const { stop } = { ...lift, ...more };
  return { ...lift, ...more, at: lift.points[Math.max(0, lift.stops.indexOf(stop))] };
}

/**
 * What a scene's tags say of fixtures, by kind. The tags are those of hmrsim/fixtures/.
 * @type {Record<string, (fixture: any, tags: string[], time: number) => object>}
 */
export const FROM_TAGS = {
  dock: (dock, tags) => ({ ...dock, docked: after(tags, 'docked:'), queue: after(tags, 'queued:') }),
  door(door, tags) {
    const state = ['open', 'opening', 'closed'].find((word) => tags.includes(word)) ?? door.state;
    return { ...door, state, locked: tags.includes('locked'), jammed: tags.includes('jammed') };
  },
  lift(lift, tags, time) {
    const [stop = lift.stop] = after(tags, 'at:');
    const [to = null] = after(tags, 'to:');
    const { departed, arrives } = to !== null && to === lift.to ? lift : { departed: to && time, arrives: null };
    return moved(lift, { stop, to, departed, arrives, carries: after(tags, 'carries:') });
  },
};

/**
 * Return the seconds from stop to stop: doors close, it moves, doors open.
 * @param {Lift} lift
 * @param {string} from
 * @param {string} to
 * @returns {number}
 */
export function rideSeconds(lift, from, to) {
  return Math.abs(lift.stops.indexOf(to) - lift.stops.indexOf(from)) * lift.travel_time + 2 * lift.door_time;
}

function after(tags, prefix) {
  return tags.filter((tag) => tag.startsWith(prefix)).map((tag) => tag.slice(prefix.length));
}
