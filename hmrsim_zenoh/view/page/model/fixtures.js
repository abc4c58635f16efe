/** Docks, doors and lifts as they are now. What is said of one is replaced and never changed. */

/**
 * @typedef {import('./motion.js').Point} Point
 * @typedef {object} Door
 * @property {string} name
 * @property {[Point, Point]} at Its jambs.
 * @property {string} type
 * @property {'open'|'opening'|'closed'} state
 * @property {number} since When that began, in simulated seconds.
 * @property {number} openingTime Seconds.
 * @property {string} by For whom it opens or has opened; or "".
 * @property {boolean} locked
 * @property {boolean} jammed
 * @property {string[]|null} opensFor
 * @property {string[]} tags
 *
 * @typedef {object} Lift
 * @property {string} name
 * @property {string[]} stops
 * @property {Point[]} points Where the stops are.
 * @property {string} stop The one where its cabin is; while it moves the one that it has left.
 * @property {Point} at Where that is.
 * @property {string|null} to The one to which it moves.
 * @property {number|null} departed
 * @property {number|null} arrives
 * @property {string[]} carries Robots.
 * @property {number} capacity
 * @property {string[]} tags
 *
 * @typedef {object} Dock
 * @property {string} name
 * @property {Point} at
 * @property {string} type
 * @property {number} capacity
 * @property {number|null} yaw
 * @property {boolean} charges
 * @property {Point|null} staging
 * @property {string[]|null} reservedFor
 * @property {string[]} docked Robots.
 * @property {string[]} queue Robots that wait for a berth, in order.
 * @property {string[]} tags
 */

/**
 * Return a door as it is in the beginning.
 * @param {import('./world.js').DoorSpec} spec
 * @returns {Door}
 */
export function newDoor(spec) {
  return withTags({
    kind: 'door', name: spec.name, at: spec.at, type: spec.type, state: spec.open ? 'open' : 'closed', since: -Infinity,
    openingTime: spec.openingTime, by: '', locked: false, jammed: false, opensFor: spec.opensFor,
  });
}

/**
 * Return a lift as it is in the beginning.
 * @param {import('./world.js').LiftSpec} spec
 * @returns {Lift}
 */
export function newLift(spec) {
  return withTags({
    kind: 'lift', name: spec.name, stops: spec.stops, points: spec.points, stop: spec.at, to: null, departed: null,
    arrives: null, carries: [], capacity: spec.capacity, travelTime: spec.travelTime, doorTime: spec.doorTime,
  });
}

/**
 * Return a dock as it is in the beginning.
 * @param {import('./world.js').DockSpec} spec
 * @returns {Dock}
 */
export function newDock(spec) {
  return withTags({ kind: 'dock', ...spec, docked: [], queue: [] });
}

/**
 * Return a fixture with some things changed, and the tags that it then has.
 * @template {Door|Lift|Dock} T
 * @param {T} fixture
 * @param {Partial<T>} more
 * @returns {T}
 */
export function changed(fixture, more) {
  return withTags({ ...fixture, ...more });
}

/**
 * Return a fixture as its tags in a scene say that it is.
 * @template {Door|Lift|Dock} T
 * @param {T} fixture
 * @param {string[]} tags
 * @param {number} time
 * @returns {T}
 */
export function fromTags(fixture, tags, time) {
  const after = (prefix) => tags.filter((tag) => tag.startsWith(prefix)).map((tag) => tag.slice(prefix.length));
  if (fixture.kind === 'dock') return { ...fixture, docked: after('docked:'), queue: after('queued:'), tags };
  if (fixture.kind === 'door') {
    const state = ['open', 'opening', 'closed'].find((word) => tags.includes(word)) ?? fixture.state;
    const since = state === fixture.state ? fixture.since : time;
    return { ...fixture, state, since, locked: tags.includes('locked'), jammed: tags.includes('jammed'), tags };
  }
  const [stop = fixture.stop] = after('at:');
  const [to = null] = after('to:');
  const goes = to !== null && to === fixture.to ? fixture : { departed: to && time, arrives: null };
  const { departed, arrives } = goes;
  return { ...fixture, stop, at: pointOf(fixture, stop), to, departed, arrives, carries: after('carries:'), tags };
}

/**
 * Return the seconds from stop to stop: doors close, it moves, doors open.
 * @param {Lift} lift
 * @param {string} from
 * @param {string} to
 * @returns {number}
 */
export function rideSeconds(lift, from, to) {
  return Math.abs(lift.stops.indexOf(to) - lift.stops.indexOf(from)) * lift.travelTime + 2 * lift.doorTime;
}

function pointOf(lift, stop) {
  return lift.points[Math.max(0, lift.stops.indexOf(stop))] ?? [0, 0];
}

/** The tags are those that hmrsim/fixtures/ gives them. */
function withTags(fixture) {
  if (fixture.kind === 'door') {
    const { state, locked, jammed } = fixture;
    fixture.tags = ['door', state, ...(locked ? ['locked'] : []), ...(jammed ? ['jammed'] : [])];
  } else if (fixture.kind === 'lift') {
    fixture.at = pointOf(fixture, fixture.stop);
    const moves = fixture.to === null ? [] : ['moving', `to:${fixture.to}`];
    fixture.tags = ['lift', `at:${fixture.stop}`, ...moves, ...fixture.carries.map((name) => `carries:${name}`)];
  } else {
    const { type, docked, queue, capacity } = fixture;
    const room = docked.length < capacity ? 'free' : 'full';
    const inside = docked.map((name) => `docked:${name}`);
    fixture.tags = [...new Set(['dock', type]), room, ...inside, ...queue.map((name) => `queued:${name}`)];
  }
  return fixture;
}
