/** The state of a simulation: changing, saving and restoring it. Events are applied in changes.js. */

import { Demand } from './demand.js';
import { NEW, applyFault, lockDoors, moved } from './fixtures.js';
import { Goals, isActive } from './goals.js';
import { History } from './history.js';
import { Robot } from './robot.js';
import { Tail } from './tail.js';
import { World } from './world.js';

const EVENTS = 5000;
const PLAIN = ['world', 'forms', 'texts', 'info', 'informed', 'time', 'deadlocks'];
const MAPS = ['items', 'doors', 'lifts', 'docks', 'closedLanes', 'faults', 'trees', 'goals'];
const COPIED = ['demand', 'history', '_events'];

/** The state of a model. */
export class State extends EventTarget {
  world = new World();
  forms = { actions: {}, faults: {} }; // JSON Schemas of the forms
  texts = {}; // templates of events
  info = null; // `_world/info`
  informed = new Map(); // its robots by name
  time = 0; // the time of the latest event, in simulated seconds
  robots = new Map();
  items = new Map(); // name, weight, at, and the carrier or null
  doors = new Map();
  lifts = new Map();
  docks = new Map();
  closedLanes = new Map(); // the reasons of closed lanes by `from|to`
  faults = new Map(); // the active faults: name, fault, and robot, lane or door
  deadlocks = []; // the `robots` of each deadlock of which none has moved yet
  goals = new Goals();
  demand = new Demand();
  trees = new Map(); // the latest message of each robot's behavior tree
  history = new History();
  _events = new Tail(EVENTS);
  _touched = new Set();

  /** @returns {object[]} The latest 5,000 events or more with their times `t`, without motions and routes; oldest first. */
  get events() { return this._events.items; }

  /** Return the objects of a kind by name; of lanes by `from|to`; undefined for what has no name, such as the floor. */
  allOf(kind) {
    const { robots, items, doors, lifts, docks, world: { places, waypoints, lanesByKey } } = this;
    return { robot: robots, item: items, door: doors, lift: lifts, dock: docks, place: places, waypoint: waypoints, lane: lanesByKey }[kind];
  }

  /** @returns {object} What `restore` takes, in this model or another. */
  snapshot() {
    const part = (names, copy) => Object.fromEntries(names.map((name) => [name, copy(this[name])]));
    return {
      plain: part(PLAIN, (value) => value),
      robots: Array.from(this.robots.values(), (robot) => robot.saved()),
      maps: part(MAPS, copyOf),
      copied: part(COPIED, (value) => value.copy()),
    };
  }

  /** Restore a snapshot. Robots that still exist stay the same objects. @param {object} saved A result of `snapshot`. */
  restore(saved) {
    if (this.world !== saved.plain.world) this.touch('world');
    Object.assign(this, saved.plain);
    const before = this.robots;
    this.robots = new Map();
    for (const state of saved.robots) {
      const robot = before.get(state.name) ?? new Robot(state.name);
      robot.restore(state);
      this.robots.set(state.name, robot);
    }
    for (const name of MAPS) this[name] = copyOf(saved.maps[name]);
    for (const name of COPIED) this[name] = saved.copied[name].copy();
    this.touch('fixtures', 'scene', 'robots', 'goals', 'orders', 'events', 'trees', 'faults');
  }

  touch(...what) {
    for (const each of what) this._touched.add(each);
  }

  /** Return a robot, which is added if it is unknown. @returns {Robot|null} Null if the name is not valid. */
  addRobot(name, type) {
    if (typeof name !== 'string' || name === '') return null;
    const known = this.robots.get(name);
    if (known) return known;
    const start = this.world.robots.get(name);
    const kind = type ?? start?.type ?? '';
    const base = start ?? this.world.types.get(kind);
    const robot = new Robot(name, kind);
    robot.radius = base?.radius ?? 0;
    robot.flies = base?.flies === true;
    if (start) robot.put(this.time, start.at[0], start.at[1], start.yaw);
    this.inform(robot);
    this.world.typeIndex(kind);
    this.robots.set(name, robot);
    this.touch('scene', 'robots');
    return robot;
  }

  /** Remove a robot or an item. */
  remove(name) {
    this.endDeadlocks(name);
    for (const map of [this.robots, this.items, this.trees, this.history.batteries]) map.delete(name);
    this.touch('scene', 'robots');
  }

  setGoal(name, action, id, more) {
    const goal = this.goals.change(name, action, id, more);
    this.touch('goals');
    const robot = this.robots.get(name);
    if (!robot) return;
    const others = robot.goals.filter((each) => each.key !== goal.key);
    if (isActive(goal.status)) others.push(goal);
    robot.goals = others;
    this.touch('robots');
  }

  setItem(name, more) {
    if (typeof name !== 'string') return;
    const item = this.items.get(name) ?? { name, weight: 0, at: null, carrier: null };
    const now = { ...item, ...more };
    this.items.set(name, now);
    if (item.carrier !== now.carrier) {
      const [giver, taker] = [this.robots.get(item.carrier), this.robots.get(now.carrier)];
      if (giver) giver.holds = giver.holds.filter((each) => each !== name);
      if (taker) taker.holds = [...taker.holds, name];
    }
    this.touch('scene', 'robots');
  }

  setDoor(name, more) { this._change(this.doors, name, (door) => ({ ...door, ...more })); }

  setLift(name, more) { this._change(this.lifts, name, (lift) => moved(lift, more)); }

  setDock(name, more) { this._change(this.docks, name, (dock) => ({ ...dock, ...more(dock) })); }

  setCharge(robot, time, percentage, charging) {
    robot.battery = { percentage, charging };
    this.history.battery(robot.name, time, percentage);
    this.touch('robots');
  }

  /** Return the reason for which a lane is closed in either direction; undefined if it is open. */
  closureOf({ key, from, to }) { return this.closedLanes.get(key) ?? this.closedLanes.get(`${to}|${from}`); }

  /** @param {string|null} why Null to open it. */
  closeLane(lane, why) {
    if (!Array.isArray(lane)) return;
    if (why === null) this.closedLanes.delete(lane.join('|'));
    else this.closedLanes.set(lane.join('|'), why);
    lockDoors(this, lane);
    this.touch('fixtures');
  }

  /** Begin or end the effects of a fault. */
  setFaultActive(fault, begins, time) {
    applyFault(this, fault, begins, time);
    this.touch('faults', 'robots');
  }

  /** End the deadlocks of a robot that has moved. */
  endDeadlocks(name) {
    if (this.deadlocks.length === 0) return;
    this.deadlocks = this.deadlocks.filter(({ robots }) => !robots.includes(name));
    this.touch('robots');
  }

  /** Forget the world's contents, as another world is about to arrive. */
  leaveWorld() {
    for (const name of ['robots', 'items', 'trees', 'closedLanes', 'faults']) this[name] = new Map();
    this.deadlocks = [];
    this.goals = new Goals();
    this.touch('fixtures', 'scene', 'robots', 'goals', 'trees', 'faults');
  }

  /** Return to the initial state of the world; spawned entities that remain are in the next scene. */
  beginAnew(time) {
    const { world } = this;
    for (const { robot, action, id, status } of this.goals.values()) {
      if (isActive(status)) this.goals.change(robot, action, id, { status: 0, ended: time });
    }
    for (const [name, { at, yaw }] of world.robots) this._begin(this.addRobot(name), time, at, yaw);
    for (const [name, { at, weight }] of world.items) this.items.set(name, { name, weight, at, carrier: null });
    for (const kind of ['door', 'lift', 'dock']) {
      this[`${kind}s`] = new Map(Array.from(world[`${kind}s`], ([name, spec]) => [name, NEW[kind](spec)]));
    }
    this.closedLanes = new Map();
    this.faults = new Map();
    this.deadlocks = [];
    this.demand.clear();
    this.touch('fixtures', 'scene', 'robots', 'orders', 'faults');
  }

  /** Restart time, and forget what was recorded over time. */
  beginTime(time) {
    this.time = time;
    this.history.clear();
    this.demand.clear();
    this.touch('orders');
    for (const robot of this.robots.values()) robot.forgetDriven();
  }

  _begin(robot, time, at, yaw) {
    robot.put(time, at[0], at[1], yaw);
    robot.setAilments({});
    Object.assign(robot, { connected: true, dock: null, holds: [], goals: [], detections: [], scriptError: '' });
    if (robot.battery) robot.battery = { percentage: 1, charging: false };
  }

  /** Set a robot's values of `_world/info`. */
  inform(robot) {
    const said = this.informed.get(robot.name);
    if (!said) return;
    const { actions = [], components = [], planner = 'graph' } = said;
    Object.assign(robot, { actions, components, planner });
  }

  _change(fixtures, name, changed) {
    const fixture = fixtures.get(name);
    if (!fixture) return;
    fixtures.set(name, changed(fixture));
    this.touch('fixtures');
  }
}

function copyOf(map) { return new map.constructor(map); }
