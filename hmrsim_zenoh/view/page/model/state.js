/** The state of a simulation: changing, saving and restoring it. Events are applied in changes.js. */

import { Demand } from './demand.js';
import { applyFault, lockDoors, moved, newDock, newDoor, newLift } from './fixtures.js';
import { Goals, isActive } from './goals.js';
import { History } from './history.js';
import { Robot } from './robot.js';
import { Tail } from './tail.js';
import { World } from './world.js';

const EVENTS = 5000;
const MAPS = ['items', 'doors', 'lifts', 'docks', 'closedLanes', 'faults', 'trees'];

/**
 * @typedef {import('./goals.js').Goal} Goal
 * @typedef {{name: string, weight: number, at: import('./motion.js').Point|null, carrier: string|null}} Item
 * @typedef {{t: number, kind: string, [field: string]: any}} LoggedEvent An event, and its time `t`.
 * @typedef {{t: number, robots: string[], lanes: string[][]}} Deadlock
 * @typedef {{name: string, fault: string, robot?: string, lane?: string[], door?: string}} Fault
 */

/** The state of a model. */
export class State extends EventTarget {
  constructor() {
    super();
    this.world = new World();
    this.forms = { actions: {}, faults: {} }; // JSON Schemas of the forms
    this.texts = {}; // templates of events
    this.info = null; // `_world/info`
    this.time = 0; // the time of the latest event, in simulated seconds
    this.robots = new Map();
    this.items = new Map();
    this.doors = new Map();
    this.lifts = new Map();
    this.docks = new Map();
    this.closedLanes = new Map(); // the reasons of closed lanes by `from|to`
    this.faults = new Map(); // the active faults
    this.deadlocks = []; // the deadlocks of which no robot has moved yet
    this.goalList = new Goals();
    this.demand = new Demand();
    this.trees = new Map(); // the latest message of each robot's behavior tree
    this.history = new History();
    this._events = new Tail(EVENTS);
    this._touched = new Set();
  }

  /** @returns {Map<string, Goal>} By id, in order of acceptance. */
  get goals() {
    return this.goalList.all;
  }

  /** @returns {LoggedEvent[]} The latest 5,000 or more, without motions and routes; oldest first. */
  get events() {
    return this._events.items;
  }

  /** @returns {object} What `restore` takes, in this model or another. */
  snapshot() {
    const { world, forms, texts, info, time, deadlocks } = this;
    return {
      plain: { world, forms, texts, info, time, deadlocks },
      robots: Array.from(this.robots.values(), (robot) => robot.saved()),
      maps: Object.fromEntries(MAPS.map((name) => [name, new Map(this[name])])),
      goals: this.goalList.saved(),
      demand: this.demand.saved(),
      history: this.history.saved(),
      events: this._events.saved(),
    };
  }

  /** Restore a snapshot. Robots that still exist stay the same objects. @param {object} saved A result of `snapshot`. */
  restore(saved) {
    const sameWorld = this.world === saved.plain.world;
    Object.assign(this, saved.plain);
    const before = this.robots;
    this.robots = new Map();
    for (const state of saved.robots) {
      const robot = before.get(state.name) ?? new Robot(state.name);
      robot.restore(state);
      this.robots.set(state.name, robot);
    }
    for (const name of MAPS) this[name] = new Map(saved.maps[name]);
    this.goalList.restore(saved.goals);
    this.demand.restore(saved.demand);
    this.history.restore(saved.history);
    this._events.restore(saved.events);
    if (!sameWorld) this.touch('world');
    this.touch('scene', 'robots', 'goals', 'orders', 'events', 'trees', 'faults');
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
    this.inform(robot, robotsOf(this.info).get(name));
    this.world.typeIndex(kind);
    this.robots.set(name, robot);
    this.touch('scene', 'robots');
    return robot;
  }

  /** Remove a robot or an item. */
  remove(name) {
    this.endDeadlocks(name);
    this.robots.delete(name);
    this.items.delete(name);
    this.trees.delete(name);
    this.history.batteries.delete(name);
    this.touch('scene', 'robots');
  }

  setGoal(name, action, id, more) {
    const goal = this.goalList.set(name, action, id, more);
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

  setDoor(name, more) {
    this._change(this.doors, name, () => more);
  }

  setLift(name, more) {
    this._change(this.lifts, name, (lift) => moved(lift, more));
  }

  setDock(name, more) {
    this._change(this.docks, name, more);
  }

  setCharge(robot, time, percentage, charging) {
    robot.battery = { percentage, charging };
    this.history.battery(robot.name, time, percentage);
    this.touch('robots');
  }

  /** Return the reason for which a lane is closed in either direction; undefined if it is open. */
  closureOf({ key, from, to }) {
    return this.closedLanes.get(key) ?? this.closedLanes.get(`${to}|${from}`);
  }

  /** @param {string|null} why Null to open it. */
  closeLane(lane, why) {
    if (!Array.isArray(lane)) return;
    if (why === null) this.closedLanes.delete(lane.join('|'));
    else this.closedLanes.set(lane.join('|'), why);
    lockDoors(this, lane);
    this.touch('scene');
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
    this.robots = new Map();
    this.items = new Map();
    this.trees = new Map();
    this.closedLanes = new Map();
    this.faults = new Map();
    this.deadlocks = [];
    this.goalList.restore(new Map());
    this.touch('scene', 'robots', 'goals', 'trees', 'faults');
  }

  /** Return to the initial state of the world; spawned entities that remain are in the next scene. */
  beginAnew(time) {
    const { world } = this;
    for (const goal of this.goals.values()) {
      if (isActive(goal.status)) this.goalList.set(goal.robot, goal.action, goal.id, { status: 0, ended: time });
    }
    for (const [name, { at, yaw }] of world.robots) this._begin(this.addRobot(name), time, at, yaw);
    for (const [name, { at, weight }] of world.items) this.items.set(name, { name, weight, at, carrier: null });
    this.doors = new Map(Array.from(world.doors, ([name, spec]) => [name, newDoor(spec)]));
    this.lifts = new Map(Array.from(world.lifts, ([name, spec]) => [name, newLift(spec)]));
    this.docks = new Map(Array.from(world.docks, ([name, spec]) => [name, newDock(spec)]));
    this.closedLanes = new Map();
    this.faults = new Map();
    this.deadlocks = [];
    this.demand.clear();
    this.touch('scene', 'robots', 'orders', 'faults');
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
    robot.connected = true;
    robot.dock = null;
    robot.holds = [];
    robot.goals = [];
    robot.detections = [];
    robot.script = null;
    if (robot.battery) robot.battery = { percentage: 1, charging: false };
  }

  /** Set a robot's values of `_world/info`. */
  inform(robot, said) {
    if (!robot || !said) return;
    robot.actions = names(said.actions);
    robot.components = names(said.components);
    robot.planner = said.planner ?? 'graph';
  }

  _change(fixtures, name, more) {
    const fixture = fixtures.get(name);
    if (!fixture) return;
    fixtures.set(name, { ...fixture, ...more(fixture) });
    this.touch('scene');
  }
}

function names(given) {
  return Array.isArray(given) ? given : Object.keys(given ?? {});
}

const said = new WeakMap();

/** Return the robots of `_world/info` by name. */
export function robotsOf(info) {
  if (!info) return new Map();
  if (!said.has(info)) said.set(info, new Map((info.robots ?? []).map((each) => [each.name, each])));
  return said.get(info);
}
