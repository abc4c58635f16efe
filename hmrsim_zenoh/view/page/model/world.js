/** The static world of `_world/view`: the map, its fixtures and the initial robots. */

/** The distance within which a point is at a named object; lifts' stops are exact. */
const HERE = { m: 0.01, px: 0.5 };
const EXACT = 1e-4;
/** The world before one is loaded. */
const EMPTY = {
  name: 'world', units: 'm', bounds: null, walls: [], waypoints: [], lanes: [], places: [], docks: [], doors: [],
  lifts: [], items: [], robot_types: [], robots: [], demand: [],
};
const BY_NAME = ['waypoints', 'places', 'docks', 'lifts', 'items', 'robots'];

/**
 * A world with the fields of `hmrsim.world_checks.resolved.shown`: `units` are m, or px with y down; `demand` are the names of
 * the sources of orders; waypoints, places, docks, doors, lifts, items, robots and types are maps by name.
 *
 * @typedef {import('./motion.js').Point} Point
 */
export class World {
  /** @param {object} [given] The `world` of `_world/view`; missing parts are empty. */
  constructor(given = undefined) {
    this.given = given;
    Object.assign(this, { ...EMPTY, ...given });
    for (const things of BY_NAME) this[things] = byName(this[things]);
    /** Lanes have their ends `a` and `b` and the `key` `from|to`. A capacity or limit of null is none. */
    this.lanes = this.lanes.map((lane) => {
      const [a, b] = [this.waypoints.get(lane.from).at, this.waypoints.get(lane.to).at];
      return { ...lane, key: `${lane.from}|${lane.to}`, a, b };
    });
    this.lanesByKey = new Map(this.lanes.map((lane) => [lane.key, lane]));
    this.doors = byName(this.doors.map((door) => ({ ...door, lanes: door.lanes.map((ends) => this.lanesByKey.get(ends.join('|'))) })));
    this.types = byName(this.robot_types.map((type, index) => ({ ...type, index }))); // in the order of their colors
    this.extent = this._extent(); // the extent of all objects, with the bounds
    this._cell = 2 * HERE[this.units];
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
  get known() { return this.given !== undefined; }

  /** Return the index of a robot type, for its color and shape; an unknown type gets the next index. */
  typeIndex(name) {
    if (!this.types.has(name)) this.types.set(name, { name, index: this.types.size, radius: null, flies: false, speed: 0 });
    return this.types.get(name).index;
  }

  /** Return the coordinates of a named waypoint, place or dock; null if there is none. */
  point(name) { return (this.waypoints.get(name) ?? this.places.get(name) ?? this.docks.get(name))?.at ?? null; }

  /** Return the name of the place, dock or waypoint at a point, or "". */
  nameAt(at) { return this._named.get(spot(at, this._cell)) ?? ''; }

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
    let found = null;
    for (const lane of this.lanes) {
      const point = nearestOn(lane.a, lane.b, x, y);
      const distance = Math.hypot(point[0] - x, point[1] - y);
      if (distance <= (found?.distance ?? most)) found = { lane, point, distance };
    }
    return found;
  }

  _extent() {
    const points = [
      ...this.walls.flatMap((wall) => wall.points), ...[...this.doors.values()].flatMap(({ at }) => at),
      ...[this.waypoints, this.places, this.docks, this.items, this.robots].flatMap((things) => Array.from(things.values(), ({ at }) => at)),
    ];
    const box = this.bounds ? [...this.bounds] : [Infinity, Infinity, -Infinity, -Infinity];
    for (const [x, y] of points) {
      [box[0], box[1]] = [Math.min(box[0], x), Math.min(box[1], y)];
      [box[2], box[3]] = [Math.max(box[2], x), Math.max(box[3], y)];
    }
    return box[0] <= box[2] ? box : [0, 0, 1, 1];
  }
}

/** Return the point of a straight line from a to b that is nearest to a point. @returns {Point} */
export function nearestOn(a, b, x, y) {
  const [dx, dy] = [b[0] - a[0], b[1] - a[1]];
  const share = Math.min(1, Math.max(0, ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy || 1)));
  return [a[0] + dx * share, a[1] + dy * share];
}

/** @template {{name: string}} T */
function byName(things) { return new Map(things.map((thing) => [thing.name, thing])); }

function spot([x, y], size = EXACT) { return `${Math.round(x / size)}|${Math.round(y / size)}`; }
