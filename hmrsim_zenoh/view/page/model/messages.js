/** Checks of received messages: they must have the shapes that the model and the map rely on. */

import { partOf } from './changes.js';

/** Return the seconds of a builtin_interfaces/msg/Time or Duration. */
export function secondsOf(stamp) {
  return stamp ? (stamp.sec || 0) + (stamp.nanosec || 0) * 1e-9 : 0;
}

const isNumber = Number.isFinite;
const isName = (value) => typeof value === 'string';
const isRecord = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);
const isOptional = (shape) => (value) => value === undefined || value === null || shape(value);
const isListOf = (shape) => (value) => Array.isArray(value) && value.every(shape);
const isNumbers = isListOf(isNumber);
const isPoint = (value) => isNumbers(value) && value.length > 1;
const isNames = isListOf(isName);
/** @param {Record<string, (value: any) => boolean>} fields Optional fields have an optional shape. */
const isLike = (fields) => {
  const all = Object.entries(fields);
  return (value) => isRecord(value) && all.every(([field, shape]) => shape(value[field]));
};
const maybe = (fields) => Object.fromEntries(Object.entries(fields).map(([field, shape]) => [field, isOptional(shape)]));

const isStamp = isLike({ sec: isNumber, nanosec: isOptional(isNumber) });
const isGoal = isLike({ action: isName, ...maybe({ goal_id: isName, stamp: isStamp, status: isNumber }) });
const MOVES = maybe({ from: isPoint, to: isPoint, duration: isNumber, turned: isNumber, lane: isNames, began: isNumber });
const isProfile = (value) => isNumbers(value) && value.length > 2;
const PIECE = { ...MOVES, profile: isOptional(isProfile) };
const isMotion = isLike({ ...PIECE, then: isOptional(isListOf(isLike(PIECE))) });

/** The optional fields of all kinds of events. */
const ANY = maybe({
  robot: isName, entity: isName, door: isName, lift: isName, dock: isName, participant: isName, by: isName,
  robots: isNames, for: isNames, lane: isNames,
});
/** The further optional fields of events that change the model. */
const KNOWN = maybe({
  action: isName, goal_id: isName, status: isNumber, item: isName, name: isName, fault: isName, why: isName,
  yaw: isNumber, points: isListOf(isPoint), percentage: isNumber, position: isNumber, factor: isNumber,
});
const FIELDS = isLike({ stamp: isStamp, kind: isName, ...ANY });
const MORE = isLike(KNOWN);
const isAt = isLike(maybe({ at: isPoint }));
/** The further fields of an event by the part that it changes. @type {Map<string, (event: any) => boolean>} */
const OF_PART = new Map([
  ...['robots.pose', 'robots.waiting', 'robots.battery', 'items.carrier', 'entities'].map((part) => [part, isAt]),
  ['robots.motion', isMotion],
  ['robots.goals', isLike({ robot: isName, action: isName })],
  ['orders', isLike({
    order: isName, item: isName,
    ...maybe({ from: isName, to: isName, priority: isNumber, within: isNumber, lead_time: isNumber, late: isNumber }),
  })],
  ['fixtures.lift', isLike(maybe({ from: isName, to: isName, stop: isName }))],
]);

/** Check an event; if it changes nothing, only the common fields count. */
function isEvent(event, texts) {
  if (!FIELDS(event)) return false;
  const part = partOf(event, texts);
  return part === '' || (MORE(event) && (OF_PART.get(part)?.(event) ?? true));
}

const isRobot = isLike({
  name: isName,
  ...maybe({
    type: isName, radius: isNumber, pose: isPoint, speed: isNumber, dock: isName, holds: isNames, route: isListOf(isPoint),
    ailments: isRecord, motion: isMotion, goals: isListOf(isGoal),
    battery: isLike({ percentage: isNumber }), sensors: isListOf(isLike({ name: isName })),
  }),
});

const isScene = isLike({
  stamp: isStamp,
  ...maybe({
    robots: isListOf(isRobot),
    items: isListOf(isLike({ name: isName, ...maybe({ at: isPoint, carrier: isName }) })),
    fixtures: isListOf(isLike({ name: isName, tags: isOptional(isNames) })),
    closed_lanes: isListOf(isLike(maybe({ lane: isNames, why: isName }))),
    faults: isListOf(isLike({ name: isName, ...maybe({ fault: isName, robot: isName, door: isName, lane: isNames }) })),
  }),
});

const isText = isLike({ text: isName, severity: isName, ...maybe({ changes: isName, sets: isRecord }) });
const isTexts = (value) => isRecord(value) && Object.values(value).every(isText);
const isThing = isLike({ name: isName, at: isPoint });
const isWorld = isLike({
  name: isName, units: isName,
  ...maybe({
    bounds: isNumbers, walls: isListOf(isLike({ points: isListOf(isPoint) })), waypoints: isListOf(isThing),
    places: isListOf(isThing), docks: isListOf(isThing), items: isListOf(isThing), robots: isListOf(isThing),
    lanes: isListOf(isLike({ from: isName, to: isName })), doors: isListOf(isLike({ name: isName, at: isListOf(isPoint) })),
    lifts: isListOf(isLike({ name: isName, stops: isNames, points: isListOf(isPoint) })),
    robot_types: isListOf(isLike({ name: isName })), demand: isNames,
  }),
});

const isCounts = isLike({ counts: isRecord, never: isNames });
const isNode = isLike({
  depth: isNumber, name: isName, status: isName, ...maybe({ kind: isName, message: isName }), coverage: isOptional(isCounts),
});

const isOrder = isLike({
  name: isName, item: isName,
  ...maybe({ at: isName, to: isName, priority: isNumber, state: isName, robot: isName, placed: isStamp, due: isStamp }),
});
const isTotals = isLike(maybe({ placed: isNumber, delivered: isNumber, late: isNumber, lost: isNumber }));

const OF_WORLD = new Map([
  ['events', isEvent],
  ['scene', isScene],
  ['view', isLike({ world: isWorld, actions: isOptional(isRecord), faults: isOptional(isRecord), events: isOptional(isTexts) })],
  ['info', isLike({ robots: isOptional(isListOf(isLike({ name: isName }))) })],
  ['demand', isLike({ stamp: isStamp, orders: isListOf(isOrder), totals: isTotals })],
  ['clock', isLike({ clock: isStamp })],
  ['time/state', isLike({ now: isNumber, real_time_factor: isNumber, ...maybe({ participants: isNames, waiting_for: isNames }) })],
]);

const OF_ROBOT = new Map([
  ['battery_state', isLike(maybe({ percentage: isNumber, header: isLike(maybe({ stamp: isStamp })) }))],
  ['_tree', isLike({ status: isName, sim_time: isOptional(isNumber), nodes: isListOf(isNode) })],
  ['detections', isLike(maybe({ detections: isListOf(isLike(maybe({ id: isName }))) }))],
  ['feedback', isLike({ goal_id: isName, feedback: isOptional(isRecord) })],
]);

/**
 * Return whether a message has the shape of its key; on unknown keys all messages are valid.
 * @param {import('./changes.js').Texts} [texts] The `events` of `_world/view`, if known.
 */
export function isValid(key, payload, texts = {}) {
  const [owner, ...topic] = key.split('/');
  const shape = owner === '_world' ? OF_WORLD.get(topic.join('/')) : OF_ROBOT.get(topic[topic.length - 1]);
  return shape === undefined || shape(payload, texts);
}
