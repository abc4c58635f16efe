/** The state of a simulation, from a world, a scene and events. No DOM, no network. */

import { change, isListed, partOf, restarts } from './changes.js';
import { FROM_TAGS } from './fixtures.js';
import { errorOf, isActive } from './goals.js';
import { isValid, secondsOf } from './messages.js';
import { motionsOf } from './motion.js';
import { Robot } from './robot.js';
import { State } from './state.js';
import { World } from './world.js';

const CHARGING = 1;
/** The parts of the state that scenes do not contain completely. */
const LASTING = new Set(['robots.goals', 'orders']);

/**
 * Dispatches 'world', 'fixtures' (which includes closed lanes), 'scene', 'goals', 'orders', 'events', 'trees', 'robots' and 'faults', each at most once a `flush()`.
 *
 * Robots, goals, items, doors, lifts, docks and lanes are in maps by name. Only robots are ever changed, all other
 * values are replaced.
 */
export class Model extends State {
  unreadable = 0; // the number of invalid messages

  /** Process a message; invalid ones are ignored and counted. @returns {boolean} Whether it was valid. */
  receive(key, payload) {
    return isValid(key, payload, this.texts) ? this.guard(key, () => this.#feed(key, payload)) : this.#leaveOut(key);
  }

  /** Run a function on a message; a failure is counted and goes no further. @returns {boolean} Whether it succeeded. */
  guard(key, take) {
    try {
      take();
      return true;
    } catch (error) {
      console.debug(key, error);
      return this.#leaveOut(key);
    }
  }

  #feed(key, payload) {
    const [owner, topic, ...more] = key.split('/');
    if (owner === '_world') FED.get(topic)?.(this, payload);
    else if (more.at(-1) === 'feedback') this.setFeedback(owner, topic, payload);
    else if (!more.length) FED_BY_ROBOTS.get(topic)?.(this, owner, payload);
  }

  #leaveOut(key) {
    this.unreadable += 1;
    this.dispatchEvent(new CustomEvent('unreadable', { detail: key }));
    return false;
  }

  /**
   * Load a world; a scene has to follow.
   * @param {{world: object, actions?: object, faults?: object, events?: object}} view `_world/view`.
   */
  loadView({ world, actions = {}, faults = {}, events = {} }) {
    this.forms = { actions, faults };
    this.texts = events;
    // After a reset the world is the same, and past goals and events stay.
    if (JSON.stringify(this.world.given) !== JSON.stringify(world)) {
      this.world = new World(world);
      this.leaveWorld();
    }
    this.items = new Map();
    this.beginAnew(0);
    this.beginTime(0);
    this.touch('world', 'scene', 'robots', 'goals', 'events', 'trees', 'faults');
  }

  /** @param {object} info `_world/info`. */
  loadInfo(info) {
    this.info = info;
    this.informed = new Map((info?.robots ?? []).map((robot) => [robot.name, robot]));
    for (const robot of this.robots.values()) this.inform(robot);
    this.touch('robots');
  }

  /** Replace the state by a scene. @param {object} scene `_world/scene`. */
  loadScene({ stamp, robots = [], items = [], fixtures = [], closed_lanes: closed = [], faults = [] }) {
    const time = secondsOf(stamp);
    if (time < this.time) this.beginTime(time);
    this.time = time;
    const before = this.robots;
    this.robots = new Map(robots.map(({ name }) => [name, before.get(name) ?? new Robot(name)]));
    for (const said of robots) this.#loadRobot(this.robots.get(said.name), said);
    this.items = new Map(items.map(({ name, weight = 0, at = null, carrier = null }) => [name, { name, weight, at, carrier }]));
    for (const { name, kind, tags = [] } of fixtures) {
      const known = FROM_TAGS[kind] && this.allOf(kind);
      if (known?.has(name)) known.set(name, FROM_TAGS[kind](known.get(name), tags));
    }
    this.closedLanes = new Map(closed.filter(({ lane }) => lane).map(({ lane, why = '' }) => [lane.join('|'), why]));
    this.faults = new Map(faults.map((fault) => [fault.name, fault]));
    for (const dock of this.docks.values()) {
      dock.queue.forEach((name, i) => {
        const robot = this.robots.get(name);
        if (robot) robot.queue = { dock: dock.name, position: i + 1, goal: robot.goal?.key };
      });
    }
    this.deadlocks = this.deadlocks.filter((each) => each.robots.every((name) => this.robots.get(name)?.waiting));
    this.history.advance(time, this.robots);
    this.touch('fixtures', 'scene', 'robots', 'goals', 'faults');
  }

  #loadRobot(robot, said) {
    const { type = '', radius = 0, flies, connected, dock = null, holds = [], battery = null, sensors = [], motion, waiting } = said;
    const [x, y, yaw = 0] = said.pose ?? [0, 0, 0];
    robot.put(this.time, x, y, yaw, true);
    Object.assign(robot, { type, radius, flies: flies === true, connected: connected !== false, dock, holds, battery, sensors });
    this.world.typeIndex(type);
    this.inform(robot);
    robot.setAilments(said.ailments ?? {});
    robot.take(said.route ?? [], (a, b) => this.world.rides(a, b));
    if (motion?.to) robot.begin(...motionsOf(motion, motion.began ?? this.time));
    if (said.waits) robot.wait(waiting?.since ?? this.time, waiting ?? {});
    if (battery) this.history.battery(robot.name, this.time, battery.percentage);
    this.#loadGoals(robot, said.goals ?? []);
  }

  /** Load the goals of a scene. Active goals that it lacks have ended. */
  #loadGoals(robot, said) {
    const listed = new Set(said.map((each) => `${each.action} ${each.goal_id}`));
    for (const { action, id } of robot.goals) {
      if (!listed.has(`${action} ${id}`)) this.goals.change(robot.name, action, id, { status: 0, ended: this.time });
    }
    robot.goals = [];
    for (const { action, goal_id: id, goal = null, stamp, ended: end = null, status = 0, result = null } of said) {
      if (!id) continue;
      const known = this.goals.find(robot.name, action, id);
      const [errorCode, errorMsg] = errorOf(result);
      const accepted = known?.accepted ?? secondsOf(stamp);
      const ended = isActive(status) ? null : (end && secondsOf(end)) ?? known?.ended ?? null;
      this.setGoal(robot.name, action, id, { goal: known?.goal ?? goal, status, accepted, ended, result, errorCode, errorMsg });
    }
  }

  /**
   * Load events from before the first scene, which has to follow: into the log, the goals and the orders.
   * @param {Record<string, any>[]} events Oldest first.
   * @param {number} until The scene's time; later events arrive by themselves.
   */
  loadLog(events, until) {
    const valid = events.filter((event) => isValid('_world/events', event, this.texts));
    const begins = valid.findLastIndex((event) => restarts(event, this.texts));
    valid.forEach((event, i) => {
      event.t = secondsOf(event.stamp);
      if (i > begins && event.t >= until) return;
      this._events.push(event);
      if (i > begins && LASTING.has(partOf(event, this.texts))) change(this, event, event.t);
    });
    this.touch('events');
  }

  /** Load the open orders, and apply the events since then again. @param {object} demand `_world/demand`. */
  loadDemand(demand) {
    this.demand.load(demand);
    this.touch('orders');
    const since = this.events.findLastIndex((event) => event.t <= secondsOf(demand.stamp)) + 1;
    for (const event of this.events.slice(since)) if (partOf(event, this.texts) === 'orders') change(this, event, event.t);
  }

  /** Apply an event. @param {Record<string, any>} event As on `_world/events`; one that changes nothing is only logged. */
  apply(event) {
    if (typeof event?.kind !== 'string') return;
    const time = secondsOf(event.stamp);
    if (time >= this.time) {
      this.history.advance(time, this.robots);
      this.time = time;
    }
    change(this, event, time);
    if (!isListed(event, this.texts)) return;
    event.t = time;
    this._events.push(event);
    this.touch('events');
  }

  /** Update a battery. @param {object} state sensor_msgs/msg/BatteryState. */
  setBattery(name, { header, percentage, power_supply_status: status }) {
    const robot = this.robots.get(name);
    if (!robot || !(percentage >= 0)) return;
    this.setCharge(robot, header?.stamp ? secondsOf(header.stamp) : this.time, percentage, status === CHARGING);
  }

  /** @param {object} state As on `<robot>/_tree`. */
  setTree(name, state) {
    this.trees.set(name, state);
    this.touch('trees');
  }

  /** @param {object} message vision_msgs/msg/Detection3DArray. */
  setDetections(name, { detections }) {
    const robot = this.robots.get(name);
    if (!robot) return;
    robot.detections = (detections ?? []).map(({ id, bbox }) => {
      const { x = 0, y = 0 } = bbox?.center?.position ?? {};
      const { z = 0, w = 1 } = bbox?.center?.orientation ?? {};
      return { id, at: [x, y, 2 * Math.atan2(z, w)] };
    });
    this.touch('robots');
  }

  setFeedback(robot, action, { goal_id: id, feedback = null }) {
    if (this.goals.find(robot, action, id)) this.setGoal(robot, action, id, { feedback });
  }

  /**
   * Dispatch the events for all changes since the last call.
   * @param {number} [time] The simulated time, if known: for the history.
   */
  flush(time) {
    if (time > this.time) this.history.advance(time, this.robots);
    const touched = this._touched;
    this._touched = new Set();
    for (const what of touched) this.dispatchEvent(new Event(what));
  }
}

const FED = new Map(Object.entries({
  events: (model, event) => model.apply(event),
  scene: (model, scene) => model.loadScene(scene),
  view: (model, view) => model.loadView(view),
  info: (model, info) => model.loadInfo(info),
  demand: (model, demand) => model.loadDemand(demand),
}));
const FED_BY_ROBOTS = new Map(Object.entries({
  battery_state: (model, robot, state) => model.setBattery(robot, state),
  _tree: (model, robot, state) => model.setTree(robot, state),
  detections: (model, robot, message) => model.setDetections(robot, message),
}));
