/** What each kind of event changes in a model. Kinds that are not here change nothing, and are told of nevertheless. */

import { rideSeconds } from './fixtures.js';
import { ACCEPTED, errorOf, isActive } from './goals.js';
import { Motion } from './motion.js';

/**
 * @typedef {import('./model.js').Model} Model
 * @typedef {Record<string, any>} Happening
 * @typedef {(model: Model, event: Happening, time: number) => void} Change
 */

const STATE_SCOPE = 2;

/** @type {Map<string, Change>} */
export const CHANGES = new Map(
  Object.entries({
    // What moves.
    motion(model, event, time) {
      const robot = model.robots.get(event.robot) ?? model.addRobot(event.robot);
      if (robot === null || !event.to) return;
      if (robot.queue !== null) unqueue(model, robot);
      if (model.deadlocks.length) model.untie(robot.name);
      robot.begin(new Motion(event, time));
      model.touch('robots');
    },
    route(model, event) {
      const robot = model.robots.get(event.robot);
      if (!robot || !Array.isArray(event.points)) return;
      robot.take(event.points, (a, b) => model.world.rides(a, b));
      model.touch('robots');
    },
    stopped(model, event, time) {
      const robot = model.robots.get(event.robot);
      if (!robot) return;
      model.untie(robot.name);
      robot.stop(time, event.at);
      model.touch('robots');
    },
    teleported(model, event, time) {
      if (!event.at) return;
      const robot = model.robots.get(event.entity);
      if (robot) {
        model.untie(robot.name);
        robot.put(time, event.at[0], event.at[1], event.yaw ?? 0);
      } else if (model.items.has(event.entity)) {
        model.setItem(event.entity, { at: event.at, carrier: null });
      }
      model.touch('robots');
    },

    // Traffic.
    waiting(model, event, time) {
      const robot = model.robots.get(event.robot);
      if (!robot) return;
      robot.wait(time, event.for ?? [], event.why ?? '', event.at);
      model.touch('robots');
    },
    went_on(model, event) {
      const robot = model.robots.get(event.robot);
      if (!robot) return;
      model.untie(robot.name);
      robot.goOn();
      model.touch('robots');
    },
    deadlock(model, event, time) {
      const robots = event.robots ?? [];
      model.deadlocks = [...model.deadlocks, { t: time, robots, lanes: event.lanes ?? [] }];
      model.touch('robots');
    },
    made_room(model, event) {
      const robot = model.robots.get(event.robot);
      if (robot) robot.makeRoom(event.by ?? '');
    },
    lane_closed(model, event) {
      model.closeLane(event.lane, event.why ?? 'closed');
    },
    lane_opened(model, event) {
      model.closeLane(event.lane, null);
    },

    // Goals.
    goal(model, event) {
      if (!event.goal_id) return;
      model.setGoal(event.robot, event.action, event.goal_id, { goal: event.goal ?? null });
    },
    status(model, event, time) {
      if (!event.goal_id) return;
      const { robot, action, goal_id: id, status = 0, result } = event;
      const more = { status };
      if (status === ACCEPTED || !model.goalList.find(robot, action, id)) more.accepted = time;
      if (!isActive(status)) {
        more.ended = time;
        more.result = result ?? null;
        [more.errorCode, more.errorMsg] = errorOf(result);
        const there = model.robots.get(robot);
        if (action === 'dock_robot' && there && there.queue !== null) unqueue(model, there);
      }
      model.setGoal(robot, action, id, more);
    },

    // Items.
    picked(model, event) {
      model.setItem(event.item, { carrier: event.robot });
    },
    placed: laid,
    dropped: laid,

    // Docks, batteries.
    dock_queued(model, event) {
      const robot = model.robots.get(event.robot);
      if (robot) robot.queue = { dock: event.dock, position: event.position ?? 1 };
      model.setDock(event.dock, ({ queue }) => ({ queue: [...without(queue, event.robot), event.robot] }));
    },
    dock_docked(model, event) {
      const robot = model.robots.get(event.robot);
      if (robot) {
        if (robot.queue !== null) unqueue(model, robot);
        robot.dock = event.dock;
      }
      model.setDock(event.dock, ({ docked }) => ({ docked: [...without(docked, event.robot), event.robot] }));
    },
    dock_undocked(model, event) {
      const robot = model.robots.get(event.robot);
      if (robot) robot.dock = null;
      model.setDock(event.dock, ({ docked }) => ({ docked: without(docked, event.robot) }));
    },
    battery_low: (model, event, time) => level(model, event, time, { batteryLevel: 'low' }),
    battery_critical: (model, event, time) => level(model, event, time, { batteryLevel: 'critical' }),
    battery_empty(model, event, time) {
      level(model, event, time, { batteryLevel: 'empty' });
      const [x, y] = event.at ?? [NaN, NaN];
      model.robots.get(event.robot)?.ail('battery_empty', `battery empty at (${+x.toPrecision(6)}, ${+y.toPrecision(6)})`);
    },
    battery_revived(model, event, time) {
      level(model, event, time, { batteryLevel: '' });
      model.robots.get(event.robot)?.ail('battery_empty', null);
    },
    battery_full: (model, event, time) => level(model, event, time, { batteryLevel: '' }),
    charging_began: (model, event, time) => level(model, event, time, {}, true),
    charging_ended: (model, event, time) => level(model, event, time, {}, false),

    // Doors and lifts.
    door_opening(model, event) {
      model.setDoor(event.door, { state: 'opening' });
    },
    door_opened(model, event) {
      model.setDoor(event.door, { state: 'open', locked: false });
    },
    door_closed(model, event) {
      model.setDoor(event.door, { state: 'closed' });
    },
    lift_departed(model, event, time) {
      model.setLift(event.lift, (lift) => {
        const arrives = time + rideSeconds(lift, event.from, event.to);
        return { stop: event.from, to: event.to, departed: time, arrives, carries: event.robots ?? [] };
      });
    },
    lift_arrived(model, event) {
      model.setLift(event.lift, () => {
        return { stop: event.stop, to: null, departed: null, arrives: null, carries: event.robots ?? [] };
      });
    },

    // Faults.
    fault_began(model, event, time) {
      if (!event.name) return;
      const { kind: _, t: __, stamp: ___, ...fault } = event;
      model.faults.set(event.name, { ...fault, since: time });
      model.hit(fault, true, time);
    },
    fault_ended(model, event, time) {
      const fault = model.faults.get(event.name);
      if (!fault) return;
      model.faults.delete(event.name);
      model.hit(fault, false, time);
    },

    // Who is there.
    spawned(model, event, time) {
      const [x, y] = event.at ?? [0, 0];
      if (event.type === 'item') {
        model.setItem(event.entity, { at: [x, y], carrier: null });
        return;
      }
      model.addRobot(event.entity, event.type)?.put(time, x, y, event.yaw ?? 0);
    },
    deleted(model, event) {
      model.remove(event.entity);
    },
    participant_joined(model, event, time) {
      model.participants.set(event.participant, time);
    },
    participant_left: left,
    participant_dropped: left,
    planner(model, event) {
      model.plannerPresent = event.present === true;
    },
    script_ended(model, event) {
      const robot = model.robots.get(event.robot);
      if (!robot) return;
      const { orders = 0, done = 0, state = '', error = '' } = event;
      robot.script = { orders, done, state, error };
      model.touch('robots');
    },

    // The simulation. Whoever feeds the model gets the scene anew, as not all that changes is told.
    simulation_state(model, event) {
      model.simulationState = event.state ?? null;
    },
    reset(model, event, time) {
      const scope = event.scope || 255;
      if (scope & STATE_SCOPE) model.beginAnew(time);
      if (time < model.time) model.beginTime(time);
    },
    world_loaded(model, _event, time) {
      if (time < model.time) model.beginTime(time);
      model.leaveWorld();
    },
  }),
);

function laid(model, event) {
  model.setItem(event.item, { at: event.at, carrier: null });
}

function left(model, event) {
  model.participants.delete(event.participant);
}

function level(model, event, time, more, charging) {
  const robot = model.robots.get(event.robot);
  if (!robot) return;
  Object.assign(robot, more);
  const percentage = event.percentage ?? robot.battery?.percentage ?? 0;
  model.setCharge(robot, time, percentage, charging ?? robot.battery?.charging ?? false);
}

/** Have a robot stand in no queue any more: it was let in, or its goal has ended. */
function unqueue(model, robot) {
  const { dock } = robot.queue;
  robot.queue = null;
  model.setDock(dock, ({ queue }) => ({ queue: without(queue, robot.name) }));
}

function without(names, name) {
  return names.filter((each) => each !== name);
}
