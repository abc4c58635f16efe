/** What does not change: the map, what is on it and who is there in the beginning, from a world file's definition. */

import { crosses } from './crossing.js';

/**
 * @typedef {import('./motion.js').Point} Point
 * @typedef {{name: string, at: Point, capacity: number|null}} Waypoint `capacity` is null for any number.
 * @typedef {{name: string, at: Point}} Place
 * @typedef {{points: Point[], solid: boolean}} Wall A solid one is closed.
 * @typedef {object} Lane
 * @property {number} index
 * @property {string} key `from|to`, as in `Model.closedLanes`.
 * @property {string} from
 * @property {string} to
 * @property {Point} a Where it begins.
 * @property {Point} b Where it ends.
 * @property {number} length
 * @property {boolean} oneWay
 * @property {number|null} speedLimit
 * @property {number|null} capacity How many robots it takes; null for any number.
 * @property {Lane|null} pair The lane in the other direction, where there is one.
 * @typedef {{name: string, index: number, base: object, components: object}} RobotType `index` is for its colour.
 * @typedef {{name: string, type: string, at: Point, yaw: number, base: object}} RobotStart
 * @typedef {{name: string, at: [Point, Point], type: string, open: boolean, openingTime: number, staysOpen: number|null,
 *   opensFor: string[]|null, lanes: Lane[]}} DoorSpec
 * @typedef {{name: string, stops: string[], points: Point[], at: string, travelTime: number, doorTime: number,
 *   capacity: number}} LiftSpec
 * @typedef {{name: string, at: Point, type: string, capacity: number, yaw: number|null, charges: boolean,
 *   staging: Point|null, reservedFor: string[]|null}} DockSpec
 * @typedef {{name: string, at: Point, weight: number, blocks: boolean}} ItemSpec
 */

const HERE = 1e-4;
const BUILT_IN = { carrier: { components: {} }, fetcher: { components: { claw: {} } } };
const NOWHERE = Object.freeze([0, 0]);
const PIXEL_SPEED = 300;

export class World {
  /** @param {object} [definition] As in a native world file. */
  constructor(definition = {}) {
    const given = definition ?? {};
    this.definition = given;
    /** @type {string} */
    this.name = given.name ?? 'world';
    /** @type {'m'|'px'} In pixels y points down. */
    this.units = given.units === 'px' ? 'px' : 'm';
    /** @type {boolean} */
    this.yDown = this.units === 'px';
    /** @type {string} The name of the policy of traffic. */
    this.policy = given.traffic?.policy ?? 'free';
    /** @type {Map<string, Waypoint>} */
    this.waypoints = new Map();
    /** @type {Map<string, Place>} */
    this.places = new Map();
    /** @type {Map<string, DockSpec>} */
    this.docks = new Map();
    this._points(given);
    /** @type {Wall[]} */
    this.walls = list(given.walls).map(wall).filter((each) => each.points.length > 1);
    /** @type {Lane[]} */
    this.lanes = [];
    /** @type {Map<string, Lane>} By `from|to`. */
    this.lanesByKey = new Map();
    this._lanes(given);
    /** @type {Map<string, DoorSpec>} */
    this.doors = new Map(entries(given.doors).map(([name, said]) => [name, this._door(name, said)]));
    /** @type {Map<string, LiftSpec>} */
    this.lifts = new Map(entries(given.lifts).map(([name, said]) => [name, this._lift(name, said)]));
    /** @type {Map<string, ItemSpec>} */
    this.items = new Map(entries(given.items).map(([name, said]) => [name, this._item(name, said)]));
    /** @type {Map<string, RobotStart>} */
    this.robots = new Map(entries(given.robots).map(([name, said]) => [name, this._robot(name, said)]));
    /** @type {Map<string, RobotType>} In order: those of the file, then built-in ones that are used. */
    this.types = new Map();
    for (const [name, said] of entries(given.robot_types)) this._type(name, said);
    for (const robot of this.robots.values()) this.typeIndex(robot.type);
    /** @type {[number, number, number, number]|null} What nothing is outside of: least x and y, greatest x and y. */
    this.bounds = Array.isArray(given.bounds) && given.bounds.length === 4 ? given.bounds : null;
    /** @type {[number, number, number, number]} What there is, with the bounds. */
    this.extent = this._extent();
    this._named = null;
    this._stops = new Map();
    for (const lift of this.lifts.values()) lift.points.forEach((at) => this._stops.set(spot(at[0], at[1]), lift.name));
  }

  /**
   * Return the index of a robot type, for its colour; one that is not known gets the next.
   * @param {string} name
   * @returns {number}
   */
  typeIndex(name) {
    return (this.types.get(name) ?? this._type(name, BUILT_IN[name] ?? {})).index;
  }

  /**
   * Return the coordinates of a point, or of a named waypoint, place or dock; null if there is none.
   * @param {Point|string|undefined} at
   * @returns {Point|null}
   */
  point(at) {
    if (Array.isArray(at)) return at;
    return (this.waypoints.get(at) ?? this.places.get(at) ?? this.docks.get(at))?.at ?? null;
  }

  /**
   * Return the name of the place, dock or waypoint that is at a point, or "".
   * @param {number} x
   * @param {number} y
   * @returns {string}
   */
  nameAt(x, y) {
    if (this._named === null) {
      this._named = new Map();
      for (const things of [this.waypoints, this.docks, this.places]) {
        for (const { name, at } of things.values()) this._named.set(spot(at[0], at[1]), name);
      }
    }
    return this._named.get(spot(x, y)) ?? '';
  }

  /**
   * Return whether from one point to the other a lift takes one.
   * @param {Point} a
   * @param {Point} b
   * @returns {boolean}
   */
  rides(a, b) {
    if (this._stops.size === 0) return false;
    const lift = this._stops.get(spot(a[0], a[1]));
    return lift !== undefined && lift === this._stops.get(spot(b[0], b[1]));
  }

  /**
   * Return the waypoint that is nearest to a point, or null if none is near enough.
   * @param {number} x
   * @param {number} y
   * @param {number} [most] How far it may be.
   * @returns {Waypoint|null}
   */
  nearestWaypoint(x, y, most = Infinity) {
    let [found, least] = [null, most * most];
    for (const waypoint of this.waypoints.values()) {
      const [dx, dy] = [waypoint.at[0] - x, waypoint.at[1] - y];
      const square = dx * dx + dy * dy;
      if (square <= least) [found, least] = [waypoint, square];
    }
    return found;
  }

  /**
   * Return the lane that is nearest to a point, and the point of it that is, or null if none is near enough.
   * @param {number} x
   * @param {number} y
   * @param {number} [most] How far it may be.
   * @returns {{lane: Lane, point: Point, distance: number}|null}
   */
  nearestLane(x, y, most = Infinity) {
    let [found, least, fx, fy] = [null, most * most, 0, 0];
    for (const lane of this.lanes) {
      const { a, b } = lane;
      const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
      const square = dx * dx + dy * dy;
      const share = square ? Math.min(1, Math.max(0, ((x - a[0]) * dx + (y - a[1]) * dy) / square)) : 0;
      const [px, py] = [a[0] + dx * share, a[1] + dy * share];
      const far = (px - x) * (px - x) + (py - y) * (py - y);
      if (far <= least) [found, least, fx, fy] = [lane, far, px, py];
    }
    return found && { lane: found, point: [fx, fy], distance: Math.sqrt(least) };
  }

  // --- reading --------------------------------------------------------------------------------------------------

  _points(given) {
    const capacity = this._capacityOf(given.traffic, 'waypoint_capacity');
    for (const [name, said] of entries(given.waypoints)) {
      const at = point(Array.isArray(said) ? said : said?.at);
      this.waypoints.set(name, { name, at, capacity: said?.capacity ?? capacity });
    }
    for (const [name, said] of entries(given.places)) this.places.set(name, { name, at: point(said?.at) });
    for (const [name, said] of entries(given.docks)) {
      this.docks.set(name, {
        name,
        at: this.point(said?.at) ?? NOWHERE,
        type: said?.type ?? 'dock',
        capacity: said?.capacity ?? 1,
        yaw: said?.yaw ?? null,
        charges: said?.type === 'charger' || said?.power > 0,
        staging: said?.staging ?? null,
        reservedFor: said?.reserved_for ?? null,
      });
    }
  }

  /** Return what traffic says of all: any number where it does not count. */
  _capacityOf(traffic, key) {
    if (this.policy === 'free') return null;
    return traffic?.[key] === undefined ? 1 : traffic[key];
  }

  _lanes(given) {
    const capacity = this._capacityOf(given.traffic, 'lane_capacity');
    for (const each of list(given.lanes)) {
      const said = Array.isArray(each) ? { from: each[0], to: each[1] } : each ?? {};
      const [a, b] = [this.waypoints.get(said.from)?.at, this.waypoints.get(said.to)?.at];
      if (!a || !b) continue;
      const key = `${said.from}|${said.to}`;
      const lane = {
        index: this.lanes.length, key, from: said.from, to: said.to, a, b,
        length: Math.hypot(b[0] - a[0], b[1] - a[1]),
        oneWay: said.one_way === true,
        speedLimit: said.speed_limit ?? null,
        capacity: said.capacity ?? capacity,
        pair: this.lanesByKey.get(`${said.to}|${said.from}`) ?? null,
      };
      if (lane.pair) lane.pair.pair = lane;
      this.lanes.push(lane);
      this.lanesByKey.set(key, lane);
    }
  }

  _door(name, said) {
    const at = list(said?.at).length === 2 ? said.at.map(point) : [NOWHERE, NOWHERE];
    return {
      name, at, type: said?.type ?? 'door', open: said?.open === true,
      openingTime: said?.opening_time ?? 2,
      staysOpen: said?.stays_open === undefined ? 3 : said.stays_open,
      opensFor: said?.opens_for ?? null,
      lanes: this.lanes.filter((lane) => crosses(lane.a, lane.b, at[0], at[1])),
    };
  }

  _lift(name, said) {
    const stops = list(said?.stops);
    return {
      name, stops, points: stops.map((stop) => this.point(stop) ?? NOWHERE), at: said?.at ?? stops[0],
      travelTime: said?.travel_time ?? 5, doorTime: said?.door_time ?? 2, capacity: said?.capacity ?? 1,
    };
  }

  _item(name, said) {
    return { name, at: this.point(said?.at) ?? NOWHERE, weight: said?.weight ?? 0, blocks: said?.blocks === true };
  }

  _robot(name, said) {
    const type = said?.type ?? 'carrier';
    const base = { ...this.definition.robot_types?.[type]?.base, ...said?.base };
    base.speed ??= this.units === 'px' ? PIXEL_SPEED : 1;
    return { name, type, at: this.point(said?.at) ?? NOWHERE, yaw: said?.yaw ?? 0, base };
  }

  _type(name, said) {
    const type = { name, index: this.types.size, base: said?.base ?? {}, components: said?.components ?? {} };
    this.types.set(name, type);
    return type;
  }

  _extent() {
    const box = this.bounds ? [...this.bounds] : [Infinity, Infinity, -Infinity, -Infinity];
    const add = ([x, y]) => {
      box[0] = Math.min(box[0], x);
      box[1] = Math.min(box[1], y);
      box[2] = Math.max(box[2], x);
      box[3] = Math.max(box[3], y);
    };
    for (const { points } of this.walls) points.forEach(add);
    for (const things of [this.waypoints, this.places, this.docks, this.items, this.robots]) {
      for (const { at } of things.values()) add(at);
    }
    for (const { at } of this.doors.values()) at.forEach(add);
    return box[0] <= box[2] ? box : [0, 0, 1, 1];
  }
}

function entries(mapping) {
  return mapping && typeof mapping === 'object' ? Object.entries(mapping) : [];
}

function list(value) {
  return Array.isArray(value) ? value : [];
}

function point(at) {
  return Array.isArray(at) && at.length >= 2 ? at : NOWHERE;
}

function wall(said) {
  return Array.isArray(said) ? { points: said, solid: false } : { points: list(said?.solid), solid: true };
}

function spot(x, y) {
  return `${Math.round(x / HERE)}|${Math.round(y / HERE)}`;
}
