/** The state of a simulation, from a world, a scene and events. No DOM, no network. */

import { change, isListed, partOf, restarts } from './changes.js';
import { FROM_TAGS } from './fixtures.js';
import { errorOf, isActive } from './goals.js';
import { isValid, secondsOf } from './messages.js';
import { motionsOf } from './motion.js';
import { Robot } from './robot.js';
import { State, robotsOf } from './state.js';
import { World } from './world.js';

function loadScene(model, scene) {
  const time = secondsOf(scene?.stamp);
  if (time < model.time) model.beginTime(time);
  model.time = time;
  loadRobots(model, scene?.robots ?? [], time);
  model.items = new Map();
  for (const { name, weight = 0, at = null, carrier = null } of scene?.items ?? []) {
    model.items.set(name, { name, weight, at, carrier });
  }
  const fixtures = { dock: model.docks, door: model.doors, lift: model.lifts };
  for (const { name, kind, tags = [] } of scene?.fixtures ?? []) {
    const known = fixtures[kind]?.get(name);
    if (known) fixtures[kind].set(name, FROM_TAGS[kind](known, tags));
  }
  model.closedLanes = new Map();
  for (const { lane, why = '' } of scene?.closed_lanes ?? []) if (lane) model.closedLanes.set(lane.join('|'), why);
  model.faults = new Map((scene?.faults ?? []).map((fault) => [fault.name, fault]));
  for (const dock of model.docks.values()) {
    dock.queue.forEach((name, i) => {
      const robot = model.robots.get(name);
      if (robot) robot.queue = { dock: dock.name, position: i + 1, goal: robot.goal?.key };
    });
  }
  model.deadlocks = model.deadlocks.filter(({ robots }) => robots.every((name) => model.robots.get(name)?.waits));
  model.history.advance(time, model.robots);
  model.touch('scene', 'robots', 'goals', 'faults');
}

function loadRobots(model, said, time) {
  const before = model.robots;
  const informed = robotsOf(model.info);
  model.robots = new Map();
  for (const each of said) {
    const robot = before.get(each.name) ?? new Robot(each.name);
    model.robots.set(each.name, robot);
    loadRobot(model, robot, each, time);
    model.inform(robot, informed.get(each.name));
  }
}

function loadRobot(model, robot, said, time) {
  const [x, y, yaw] = said.pose ?? [0, 0, 0];
  robot.arrive(time, x, y, yaw ?? 0);
  robot.type = said.type ?? '';
  model.world.typeIndex(robot.type);
  robot.radius = said.radius ?? 0;
  robot.flies = said.flies === true;
  robot.connected = said.connected !== false;
  robot.dock = said.dock ?? null;
  robot.holds = said.holds ?? [];
  robot.setAilments(said.ailments ?? {});
  robot.battery = said.battery ?? null;
  robot.sensors = said.sensors ?? [];
  robot.take(said.route ?? [], (a, b) => model.world.rides(a, b));
  if (said.motion?.to) robot.begin(...motionsOf(said.motion, said.motion.began ?? time));
  if (said.waits) robot.wait(said.waiting?.since ?? time, said.waiting?.for ?? [], said.waiting?.why ?? '');
  if (robot.battery) model.history.battery(robot.name, time, robot.battery.percentage);
  loadGoals(model, robot, said.goals ?? [], time);
}

/** Load the goals of a scene. Active goals that it lacks have ended. */
function loadGoals(model, robot, said, time) {
  const listed = new Set(said.map((each) => `${each.action} ${each.goal_id}`));
  for (const { action, id } of robot.goals) {
    if (!listed.has(`${action} ${id}`)) model.goalList.set(robot.name, action, id, { status: 0, ended: time });
  }
  robot.goals = [];
  for (const { action, goal_id: id, goal = null, stamp, ended: end = null, status = 0, result = null } of said) {
    if (!id) continue;
    const known = model.goalList.find(robot.name, action, id);
    const [errorCode, errorMsg] = errorOf(result);
    const accepted = known?.accepted ?? secondsOf(stamp);
    const ended = isActive(status) ? null : (end && secondsOf(end)) ?? known?.ended ?? null;
    const more = { goal: known?.goal ?? goal, status, accepted, ended, result, errorCode, errorMsg };
    model.setGoal(robot.name, action, id, more);
  }
}

/**
 * Dispatches 'world', 'scene', 'goals', 'orders', 'events', 'trees', 'robots' and 'faults', each at most once a `flush()`.
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
    if (!sameValues(this.world.given, world)) {
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
    for (const said of info?.robots ?? []) this.inform(this.robots.get(said.name), said);
    this.touch('robots');
  }

  /** Replace the state by a scene. @param {object} scene `_world/scene`. */
  loadScene(scene) {
    loadScene(this, scene);
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
    const loaded = secondsOf(demand.stamp);
    const since = this.events.findLastIndex((event) => event.t <= loaded) + 1;
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
    this._touched.add('events');
  }

  /** Update a battery. @param {object} state sensor_msgs/msg/BatteryState. */
  setBattery(name, state) {
    const robot = this.robots.get(name);
    if (!robot || !(state?.percentage >= 0)) return;
    const time = state.header?.stamp ? secondsOf(state.header.stamp) : this.time;
    this.setCharge(robot, time, state.percentage, state.power_supply_status === CHARGING);
  }

  /** @param {object} state As on `<robot>/_tree`. */
  setTree(name, state) {
    this.trees.set(name, state);
    this.touch('trees');
  }

  /** @param {object} message vision_msgs/msg/Detection3DArray. */
  setDetections(name, message) {
    const robot = this.robots.get(name);
    if (!robot) return;
    robot.detections = (message?.detections ?? []).map(({ id, results, bbox }) => {
      const { x = 0, y = 0 } = bbox?.center?.position ?? {};
      const { z = 0, w = 1 } = bbox?.center?.orientation ?? {};
      return { id, kind: results?.[0]?.hypothesis?.class_id ?? '', at: [x, y, 2 * Math.atan2(z, w)] };
    });
    this.touch('robots');
  }

  setFeedback(robot, action, message) {
    if (this.goalList.find(robot, action, message?.goal_id)) {
      this.setGoal(robot, action, message.goal_id, { feedback: message.feedback ?? null });
    }
  }

  /**
   * Dispatch the events for all changes since the last call.
   * @param {number} [time] The simulated time, if known: for the history.
   */
  flush(time) {
    if (time > this.time) this.history.advance(time, this.robots);
    if (this._touched.size === 0) return;
    const touched = this._touched;
    this._touched = new Set();
    for (const what of touched) this.dispatchEvent(new Event(what));
  }
}

const CHARGING = 1;
/** The parts of the state that scenes do not contain completely. */
const LASTING = new Set(['robots.goals', 'orders']);

const FED = new Map([
  ['events', (model, event) => model.apply(event)],
  ['scene', (model, scene) => model.loadScene(scene)],
  ['view', (model, view) => model.loadView(view)],
  ['info', (model, info) => model.loadInfo(info)],
  ['demand', (model, demand) => model.loadDemand(demand)],
]);
const FED_BY_ROBOTS = new Map([
  ['battery_state', (model, robot, state) => model.setBattery(robot, state)],
  ['_tree', (model, robot, state) => model.setTree(robot, state)],
  ['detections', (model, robot, message) => model.setDetections(robot, message)],
]);

function sameValues(a, b) {
  return JSON.stringify(a) === JSON.stringify(b);
}
