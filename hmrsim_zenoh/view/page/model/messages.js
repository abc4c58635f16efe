/** Checks of received messages: they must have the shapes that the model and the map rely on. */

import { partOf } from './changes.js';

/** Return the seconds of a builtin_interfaces/msg/Time or Duration. */
export function secondsOf(stamp) { return stamp ? (stamp.sec || 0) + (stamp.nanosec || 0) * 1e-9 : 0; }

const number = Number.isFinite;
const name = (value) => typeof value === 'string';
const record = (value) => typeof value === 'object' && value !== null && !Array.isArray(value);

/**
 * Return a check of a shape: a function, a list of one shape for its items, or a record of fields. A field whose name ends
 * with a question mark may be missing or null.
 */
function like(shape) {
  if (typeof shape === 'function') return shape;
  if (Array.isArray(shape)) {
    const item = like(shape[0]);
    return (value) => Array.isArray(value) && value.every(item);
  }
  const fields = Object.entries(shape).map(([key, each]) => [key.replace('?', ''), key.endsWith('?'), like(each)]);
  return (value) => record(value) && fields.every(([field, optional, fits]) => (optional && (value[field] ?? null) === null) || fits(value[field]));
}

const names = like([name]);
const numbers = like([number]);
const point = (value) => numbers(value) && value.length > 1;
const points = like([point]);
const profile = (value) => numbers(value) && value.length > 2;
const stamp = like({ sec: number, 'nanosec?': number });

const PIECE = {
  'from?': point, 'to?': point, 'duration?': number, 'turned?': number, 'lane?': names, 'began?': number, 'profile?': profile,
};
const motion = like({ ...PIECE, 'then?': [PIECE] });

/** The common fields of events. */
const isAnyEvent = like({
  stamp, kind: name, 'robot?': name, 'entity?': name, 'door?': name, 'lift?': name, 'dock?': name, 'participant?': name,
  'by?': name, 'robots?': names, 'for?': names, 'lane?': names,
});
/** The further fields of events that change the model. */
const changesModel = like({
  'action?': name, 'goal_id?': name, 'status?': number, 'item?': name, 'name?': name, 'fault?': name, 'why?': name,
  'yaw?': number, 'points?': points, 'percentage?': number, 'position?': number, 'factor?': number,
});
const isAt = like({ 'at?': point });
/** The further fields of an event by the part that it changes. @type {Map<string, (event: any) => boolean>} */
const OF_PART = new Map([
  ...['robots.pose', 'robots.waiting', 'robots.battery', 'items.carrier', 'entities'].map((part) => [part, isAt]),
  ['robots.motion', motion],
  ['robots.goals', like({ robot: name, action: name })],
  ['orders', like({
    order: name, item: name, 'from?': name, 'to?': name, 'priority?': number, 'within?': number, 'lead_time?': number, 'late?': number,
  })],
  ['fixtures.lift', like({ 'from?': name, 'to?': name, 'stop?': name })],
]);

/** Check an event; if it changes nothing, only the common fields count. */
function isEvent(event, texts) {
  if (!isAnyEvent(event)) return false;
  const part = partOf(event, texts);
  return part === '' || (changesModel(event) && (OF_PART.get(part)?.(event) ?? true));
}

const ROBOT = {
  name, 'type?': name, 'radius?': number, 'pose?': point, 'speed?': number, 'dock?': name, 'holds?': names, 'route?': points,
  'ailments?': record, 'motion?': motion, 'battery?': { percentage: number }, 'sensors?': [{ name }],
  'goals?': [{ action: name, 'goal_id?': name, 'stamp?': stamp, 'status?': number }],
};
const THINGS = [{ name, at: point }];
const WORLD = {
  name, units: name, 'bounds?': numbers, 'walls?': [{ points }], 'waypoints?': THINGS, 'places?': THINGS, 'docks?': THINGS,
  'items?': THINGS, 'robots?': THINGS, 'lanes?': [{ from: name, to: name }], 'doors?': [{ name, at: points }],
  'lifts?': [{ name, stops: names, points }], 'robot_types?': [{ name }], 'demand?': names,
};
const isText = like({ text: name, severity: name, 'changes?': name, 'sets?': record });

/** The shapes of messages by topic: those of the world, then those of robots. */
const OF_WORLD = new Map(Object.entries({
  events: isEvent,
  scene: like({
    stamp, 'robots?': [ROBOT], 'items?': [{ name, 'at?': point, 'carrier?': name }], 'fixtures?': [{ name, 'tags?': names }],
    'closed_lanes?': [{ 'lane?': names, 'why?': name }],
    'faults?': [{ name, 'fault?': name, 'robot?': name, 'door?': name, 'lane?': names }],
  }),
  view: like({
    world: WORLD, 'actions?': record, 'faults?': record, 'events?': (texts) => record(texts) && Object.values(texts).every(isText),
  }),
  info: like({ 'robots?': [{ name }] }),
  demand: like({
    stamp, totals: { 'placed?': number, 'delivered?': number, 'late?': number, 'lost?': number },
    orders: [{ name, item: name, 'at?': name, 'to?': name, 'priority?': number, 'state?': name, 'robot?': name, 'placed?': stamp, 'due?': stamp }],
  }),
  clock: like({ clock: stamp }),
  'time/state': like({ now: number, real_time_factor: number, 'participants?': names, 'waiting_for?': names }),
}));
const OF_ROBOT = new Map(Object.entries({
  battery_state: like({ 'percentage?': number, 'header?': { 'stamp?': stamp } }),
  _tree: like({
    status: name, 'sim_time?': number,
    nodes: [{ depth: number, name, status: name, 'kind?': name, 'message?': name, 'coverage?': { counts: record, never: names } }],
  }),
  detections: like({ 'detections?': [{ 'id?': name }] }),
  feedback: like({ goal_id: name, 'feedback?': record }),
}));

/**
 * Return whether a message has the shape of its key; on unknown keys all messages are valid.
 * @param {Record<string, object>} [texts] The `events` of `_world/view`, if known.
 */
export function isValid(key, payload, texts = {}) {
  const [owner, ...topic] = key.split('/');
  const shape = owner === '_world' ? OF_WORLD.get(topic.join('/')) : OF_ROBOT.get(topic.at(-1));
  return shape === undefined || shape(payload, texts);
}
