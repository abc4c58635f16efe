/** Taking over a scene: all that can be seen at one instant, whatever was believed before. */

import { FROM_TAGS } from './fixtures.js';
import { errorOf, isActive } from './goals.js';
import { motionsOf } from './motion.js';
import { Robot } from './robot.js';
import { secondsOf } from './stamps.js';
import { saidOf } from './state.js';

/**
 * Have a model be as a scene says.
 * @param {import('./model.js').Model} model
 * @param {object} scene `_world/scene`.
 */
export function loadScene(model, scene) {
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
    if (known) fixtures[kind].set(name, FROM_TAGS[kind](known, tags, time));
  }
  model.closedLanes = new Map();
  for (const { lane, why = '' } of scene?.closed_lanes ?? []) if (lane) model.closedLanes.set(lane.join('|'), why);
  const before = model.faults;
  model.faults = new Map();
  for (const fault of scene?.faults ?? []) {
    model.faults.set(fault.name, { ...fault, since: before.get(fault.name)?.since ?? null });
  }
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
  const informed = saidOf(model.info);
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
  robot.speed = said.speed ?? null;
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

/** Know the goals of a scene; those believed to go on that are not in it have ended. */
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
