/** How events change a model, by the part of the picture that their kind declares in `_world/view`. */

import { spot } from './fixtures.js';
import { ACCEPTED, errorOf, isActive } from './goals.js';
import { motionsOf } from './motion.js';

const STATE_SCOPE = 2;

/**
 * Return the part of the picture that an event changes, or "".
 * @param {Record<string, {changes?: string, sets?: object}>} texts The `events` of `_world/view`.
 */
export function partOf(event, texts) { return (Object.hasOwn(texts, event.kind) && texts[event.kind].changes) || ''; }

/** Return whether an event belongs in the log; motions and routes do not, as there is one for each lane. */
export function isListed(event, texts) { return !['robots.motion', 'robots.route'].includes(partOf(event, texts)); }

/** Return whether an event replaces the whole state: a reset or another world. */
export function restarts(event, texts) { return ['scene', 'world'].includes(partOf(event, texts)); }

/** Apply an event to a model. */
export function change(model, event, time) {
  const then = CHANGES.get(partOf(event, model.texts));
  if (then) then(model, { ...event, ...model.texts[event.kind].sets }, time);
}

/**
 * By `Part` of hmrsim/events/_event.py; an event has its fields, and those that its kind `sets`.
 * @type {Map<string, (model: import('./model.js').Model, event: Record<string, any>, time: number) => void>}
 */
export const CHANGES = new Map(
  Object.entries({
    'robots.motion'(model, event, time) {
      const robot = model.robots.get(event.robot) ?? model.addRobot(event.robot);
      if (robot === null || !event.to) return;
      if (robot.queue !== null) leaveQueue(model, robot);
      if (model.deadlocks.length) model.endDeadlocks(robot.name);
      robot.begin(...motionsOf(event, time));
      model.touch('robots');
    },
    'robots.route': ofRobot((model, robot, { points }) => {
      if (Array.isArray(points)) robot.take(points, (a, b) => model.world.rides(a, b));
    }),
    'robots.pose': ofRobot((model, robot, { at }, time) => {
      model.endDeadlocks(robot.name);
      robot.stop(time, at);
    }),
    'robots.waiting': ofRobot((model, robot, event, time) => {
      if (event.waits) return robot.wait(time, event);
      model.endDeadlocks(robot.name);
      robot.waiting = null;
    }),
    'robots.yielding': ofRobot((_model, robot, { by = '' }) => robot.makeRoom(by)),
    'robots.goals': changeGoal,
    'robots.dock': changeDock,
    'robots.battery': ofRobot(changeBattery),
    'robots.script': ofRobot((_model, robot, { error = '' }) => (robot.scriptError = error)),
    'items.carrier'(model, { item, carried, robot, at }) {
      model.setItem(item, carried ? { carrier: robot } : { at, carrier: null });
    },
    entities(model, event, time) {
      if (event.present === false) model.remove(event.entity);
      else if (event.present) addEntity(model, event, time);
      else moveEntity(model, event, time);
    },
    'fixtures.door'(model, { door, state, locked }) {
      model.setDoor(door, locked === undefined ? { state } : { state, locked });
    },
    'fixtures.lift'(model, { lift, moves, stop, from, to }) {
      model.setLift(lift, moves ? { stop: from, to } : { stop, to: null });
    },
    closed_lanes(model, { lane, closed, why = 'closed' }) {
      model.closeLane(lane, closed ? why : null);
    },
    deadlocks(model, { robots = [] }) {
      model.deadlocks = [...model.deadlocks, { robots }];
      model.touch('robots');
    },
    faults(model, { kind: _, t: __, stamp: ___, active, ...fault }, time) {
      const known = active ? fault : model.faults.get(fault.name);
      if (!known?.name) return;
      if (active) model.faults.set(known.name, known);
      else model.faults.delete(known.name);
      model.setFaultActive(known, active, time);
    },
    orders(model, event, time) {
      model.demand.note(event, time);
      model.touch('orders');
    },
    // Events of these parts are only logged.
    participants() {},
    planner_present() {},
    simulation_state() {},
    // The source also gets the scene again, as the event does not contain all changes.
    scene(model, { scope }, time) {
      if ((scope || 255) & STATE_SCOPE) model.beginAnew(time);
      if (time < model.time) model.beginTime(time);
    },
    world(model, _event, time) {
      if (time < model.time) model.beginTime(time);
      model.leaveWorld();
    },
  }),
);

/** Return a change of the event's robot, if the robot is known. */
function ofRobot(then) {
  return (model, event, time) => {
    const robot = model.robots.get(event.robot);
    if (!robot) return;
    then(model, robot, event, time);
    model.touch('robots');
  };
}

/** Set the request or the status of a goal. */
function changeGoal(model, { robot: name, action, goal_id: id, goal, status, result = null }, time) {
  if (!id) return;
  const more = status === undefined ? { goal: goal ?? null } : { status };
  if (status === ACCEPTED) more.accepted = time;
  if (status !== undefined && !isActive(status)) {
    const [errorCode, errorMsg] = errorOf(result);
    Object.assign(more, { ended: time, result, errorCode, errorMsg });
    const robot = model.robots.get(name);
    if (robot?.queue && robot.queue.goal === model.goals.find(name, action, id)?.key) leaveQueue(model, robot);
  }
  model.setGoal(name, action, id, more);
}

function changeDock(model, { robot: name, dock, state, position = 1 }) {
  const robot = model.robots.get(name);
  const list = state === 'queued' ? 'queue' : 'docked';
  if (robot) {
    if (robot.queue !== null && state !== 'away') leaveQueue(model, robot);
    if (state === 'queued') robot.queue = { dock, position, goal: robot.goal?.key };
    else robot.dock = state === 'docked' ? dock : null;
  }
  model.setDock(dock, (known) => {
    const others = without(known[list], name);
    return { [list]: state === 'away' ? others : [...others, name] };
  });
}

function changeBattery(model, robot, event, time) {
  const { level, disables, enables, at, percentage = robot.battery?.percentage ?? 0 } = event;
  if (disables) robot.disable(disables, `battery ${level} at ${spot(at)}`);
  if (enables) robot.disable(enables, null);
  model.setCharge(robot, time, percentage, event.charging ?? robot.battery?.charging ?? false);
}

function addEntity(model, { entity, type, at = [0, 0], yaw = 0 }, time) {
  if (type === 'item') model.setItem(entity, { at: [at[0], at[1]], carrier: null });
  else model.addRobot(entity, type)?.put(time, at[0], at[1], yaw);
}

function moveEntity(model, { entity, at, yaw = 0 }, time) {
  if (!at) return;
  const robot = model.robots.get(entity);
  if (robot) {
    model.endDeadlocks(robot.name);
    robot.put(time, at[0], at[1], yaw);
  } else if (model.items.has(entity)) {
    model.setItem(entity, { at, carrier: null });
  }
  model.touch('robots');
}

/** Remove a robot from its queue: it may enter the dock, or its goal has ended. */
function leaveQueue(model, robot) {
  const { dock } = robot.queue;
  robot.queue = null;
  model.setDock(dock, ({ queue }) => ({ queue: without(queue, robot.name) }));
}

function without(names, name) { return names.filter((each) => each !== name); }
