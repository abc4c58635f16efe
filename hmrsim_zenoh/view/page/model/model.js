/** What there is and how it is now: made of a world, a scene and events; no DOM, no network. */

import { change, isListed, partOf, restarts } from './changes.js';
import { loadScene } from './scene.js';
import { isSound } from './shapes.js';
import { secondsOf } from './stamps.js';
import { State } from './state.js';
import { World } from './world.js';

/**
 * Dispatches 'world', 'scene', 'goals', 'orders', 'events', 'trees', 'robots' and 'faults', each at most once a `flush()`.
 *
 * Robots, goals, items, doors, lifts, docks and lanes are in maps by name; of what is in them only robots are ever
 * changed, the others are replaced.
 */
export class Model extends State {
  /** How much was received that is not as it should be. */
  unreadable = 0;

  /**
   * Take what came on a key; what can't be read is left out and counted.
   * @param {string} key Below the prefix.
   * @param {any} payload
   * @returns {boolean} Whether it was taken.
   */
  receive(key, payload) {
    return isSound(key, payload, this.texts) ? this.guard(key, () => this.#feed(key, payload)) : this.#leaveOut(key);
  }

  /**
   * Do something with what came on a key; if that fails, the rest goes on.
   * @param {string} key
   * @param {() => void} take
   * @returns {boolean} Whether it was done.
   */
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
   * Begin with another world; a scene should follow.
   * @param {{world: object, actions?: object, faults?: object, events?: object}} view `_world/view`.
   */
  loadView({ world, actions = {}, faults = {}, events = {} }) {
    this.forms = { actions, faults };
    this.texts = events;
    // After a reset it is the same, and what was done in it stays known.
    if (!sameValues(this.world.given, world)) {
      this.world = new World(world);
      this.leaveWorld();
    }
    this.participants = new Map();
    this.items = new Map();
    this.beginAnew(0);
    this.beginTime(0);
    this.touch('world', 'scene', 'robots', 'goals', 'events', 'trees', 'faults');
  }

  /** @param {object} info `_world/info`. */
  loadInfo(info) {
    this.info = info;
    this.plannerPresent = info?.planner_present === true;
    for (const said of info?.robots ?? []) this.inform(this.robots.get(said.name), said);
    this.touch('robots');
  }

  /**
   * Be as a scene says, whatever was known before.
   * @param {object} scene `_world/scene`.
   */
  loadScene(scene) {
    loadScene(this, scene);
  }

  /**
   * Know what happened before the first scene, which has to come next: for the log, and of goals and orders.
   * @param {Record<string, any>[]} events Oldest first.
   * @param {number} until The scene's time: what happened then comes as an event, too.
   */
  loadLog(events, until) {
    const sound = events.filter((event) => isSound('_world/events', event, this.texts));
    const begins = sound.findLastIndex((event) => restarts(event, this.texts));
    sound.forEach((event, i) => {
      event.t = secondsOf(event.stamp);
      if (i > begins && event.t >= until) return;
      this._events.push(event);
      if (i > begins && LASTING.has(partOf(event, this.texts))) change(this, event, event.t);
    });
    this.touch('events');
  }

  /**
   * Know the open orders as the simulator does; what has happened since then is not forgotten.
   * @param {object} said `_world/demand`.
   */
  loadDemand(said) {
    this.demand.load(said);
    this.touch('orders');
    const told = secondsOf(said.stamp);
    const since = this.events.findLastIndex((event) => event.t <= told) + 1;
    for (const event of this.events.slice(since)) if (partOf(event, this.texts) === 'orders') change(this, event, event.t);
  }

  /**
   * Take note of something that has happened.
   * @param {Record<string, any>} event As on `_world/events`; one that changes nothing is only listed.
   */
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

  /**
   * Take note of a battery.
   * @param {string} name The robot's.
   * @param {object} state sensor_msgs/msg/BatteryState.
   */
  setBattery(name, state) {
    const robot = this.robots.get(name);
    if (!robot || !(state?.percentage >= 0)) return;
    const time = state.header?.stamp ? secondsOf(state.header.stamp) : this.time;
    this.setCharge(robot, time, state.percentage, state.power_supply_status === CHARGING);
  }

  /**
   * @param {string} name The robot's.
   * @param {object} state As on `<robot>/_tree`.
   */
  setTree(name, state) {
    this.trees.set(name, state);
    this.touch('trees');
  }

  /**
   * @param {string} name The robot's.
   * @param {object} message vision_msgs/msg/Detection3DArray.
   */
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

  /**
   * @param {string} robot
   * @param {string} action
   * @param {{goal_id: string, feedback: object}} message
   */
  setFeedback(robot, action, message) {
    if (this.goalList.find(robot, action, message?.goal_id)) {
      this.setGoal(robot, action, message.goal_id, { feedback: message.feedback ?? null });
    }
  }

  /**
   * Tell of what has changed since the last time.
   * @param {number} [time] How late it is, in simulated seconds, if that is known: for the history.
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
/** What scenes don't tell all of. */
const LASTING = new Set(['robots.goals', 'orders']);

const FED = new Map([
  ['events', (model, event) => model.apply(event)],
  ['scene', (model, scene) => model.loadScene(scene)],
  ['view', (model, view) => model.loadView(view)],
  ['info', (model, info) => model.loadInfo(info)],
  ['demand', (model, said) => model.loadDemand(said)],
]);
const FED_BY_ROBOTS = new Map([
  ['battery_state', (model, robot, state) => model.setBattery(robot, state)],
  ['_tree', (model, robot, state) => model.setTree(robot, state)],
  ['detections', (model, robot, message) => model.setDetections(robot, message)],
]);

function sameValues(a, b) {
  return JSON.stringify(a) === JSON.stringify(b);
}
