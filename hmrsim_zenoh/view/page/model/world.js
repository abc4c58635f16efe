/** The static world of `_world/view`: the map, its fixtures and the initial robots. */

/**
 * @typedef {import('./motion.js').Point} Point
 * @typedef {{name: string, at: Point, capacity: number|null}} Waypoint `capacity` is null for any number.
 * @typedef {{name: string, at: Point}} Place
 * @typedef {{points: Point[], solid: boolean}} Wall A solid wall is a closed polygon.
 * @typedef {object} Lane
 * @property {string} key `from|to`, as in `Model.closedLanes`.
 * @property {string} from
 * @property {string} to
 * @property {Point} a The first end.
 * @property {Point} b The second end.
 * @property {number} length
 * @property {boolean} one_way
 * @property {number|null} speed_limit
 * @property {number|null} capacity The largest number of robots; null for any.
 * @typedef {{name: string, index: number, radius: number|null, flies: boolean, speed: number}} RobotType `index` is
 *   for its color and shape.
 * @typedef {{name: string, type: string, at: Point, yaw: number, radius: number|null, flies: boolean, speed: number}} RobotStart
 * @typedef {{name: string, at: [Point, Point], type: string, open: boolean, lanes: Lane[]}} DoorSpec
 * @typedef {{name: string, stops: string[], points: Point[], at: string, travel_time: number, door_time: number,
 *   capacity: number}} LiftSpec
 * @typedef {{name: string, at: Point, type: string, capacity: number, charges: boolean,
 *   reserved_for: string[]|null}} DockSpec
 * @typedef {{name: string, at: Point, weight: number, blocks: boolean}} ItemSpec
 */

/** The distance within which a point is at a named object; lifts' stops are exact. */
const HERE = { m: 0.01, px: 0.5 };
const EXACT = 1e-4;
/** The world before one is loaded. */
const EMPTY = {
  name: 'world', units: 'm', bounds: null, walls: [], waypoints: [], lanes: [], places: [], docks: [], doors: [],
  lifts: [], items: [], robot_types: [], robots: [], demand: [],
};

export class World {
  /** @param {object} [given] The `world` of `_world/view`; missing parts are empty. */
  constructor(given = undefined) {
    const all = { ...EMPTY, ...given };
    this.given = given;
    this.name = all.name;
    /** @type {'m'|'px'} In pixels y points down. */
    this.units = all.units;
    this.bounds = all.bounds; // least x and y, greatest x and y of the bounds
    this.walls = all.walls;
    this.waypoints = byName(all.waypoints);
    this.places = byName(all.places);
    this.docks = byName(all.docks);
    this.lifts = byName(all.lifts);
    this.items = byName(all.items);
    this.robots = byName(all.robots);
    this.demand = all.demand; // the names of the sources of orders
    /** @type {Lane[]} */
    this.lanes = all.lanes.map((lane) => {
      const [a, b] = [this.waypoints.get(lane.from).at, this.waypoints.get(lane.to).at];
      return { ...lane, key: `${lane.from}|${lane.to}`, a, b };
    });
    this.lanesByKey = new Map(this.lanes.map((lane) => [lane.key, lane])); // by `from|to`
    /** @type {Map<string, DoorSpec>} */
    this.doors = byName(all.doors.map((door) => {
      return { ...door, lanes: door.lanes.map((ends) => this.lanesByKey.get(ends.join('|'))) };
    }));
    this.types = byName(all.robot_types.map((type, index) => ({ ...type, index }))); // in the order of their colors
    this.extent = this._extent(); // the extent of all objects, with the bounds
    this._cell = 2 * HERE[all.units];
    this._named = new Map(); // by the cells around each object, so that none is found at one side only
    for (const things of [this.waypoints, this.docks, this.places]) {
      for (const { name, at } of things.values()) {
        const [x, y] = at.map((each) => Math.floor(each / this._cell));
        for (const key of [`${x}|${y}`, `${x + 1}|${y}`, `${x}|${y + 1}`, `${x + 1}|${y + 1}`]) this._named.set(key, name);
      }
    }
    this._stops = new Map();
    for (const { name, points } of this.lifts.values()) points.forEach((at) => this._stops.set(spot(at), name));
  }

  /** @returns {boolean} Whether there is a world. */
  get known() {
    return this.given !== undefined;
  }

  /** Return the index of a robot type, for its color and shape; an unknown type gets the next index. */
  typeIndex(name) {
    if (!this.types.has(name)) this.types.set(name, { name, index: this.types.size, radius: null, flies: false, speed: 0 });
    return this.types.get(name).index;
  }

  /** Return the coordinates of a named waypoint, place or dock; null if there is none. */
  point(name) {
    return (this.waypoints.get(name) ?? this.places.get(name) ?? this.docks.get(name))?.at ?? null;
  }

  /** Return the name of the place, dock or waypoint at a point, or "". */
  nameAt(at) {
    return this._named.get(spot(at, this._cell)) ?? '';
  }

  /** Return a text with names instead of the coordinates of named points. */
  withNames(text) {
    return text.replaceAll(/\((-?[\d.]+), (-?[\d.]+)\)/g, (point, x, y) => this.nameAt([Number(x), Number(y)]) || point);
  }

  /** Return whether a lift carries robots from one point to the other. */
  rides(a, b) {
    if (this._stops.size === 0) return false;
    const lift = this._stops.get(spot(a));
    return lift !== undefined && lift === this._stops.get(spot(b));
  }

  /**
   * Return the lane nearest to a point, with its nearest point, or null if none is near enough.
   * @param {number} [most] The largest distance.
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

/** @template {{name: string}} T */
function byName(things) {
  return new Map(things.map((thing) => [thing.name, thing]));
}

function spot([x, y], size = EXACT) {
  return `${Math.round(x / size)}|${Math.round(y / size)}`;
}
