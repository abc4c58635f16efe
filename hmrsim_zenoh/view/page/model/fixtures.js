/** Docks, doors and lifts, and the effects of faults. A fixture's state is replaced and never changed. */

/** The initial states of fixtures: what the world says of them, and what changes. */
export const NEW = {
  door: (spec) => ({ ...spec, state: spec.open ? 'open' : 'closed', locked: false, jammed: false }),
  lift: (spec) => moved({ ...spec, to: null }, { stop: spec.at }), // `to` is the destination; null at rest
  dock: (spec) => ({ ...spec, docked: [], queue: [] }), // the robots in it, and those that wait for a berth, in order
};

/** Return a lift with some values replaced; while it moves, it is at the `stop` that it has left. */
export function moved(lift, more) {
  const { stop } = { ...lift, ...more };
  return { ...lift, ...more, at: lift.points[Math.max(0, lift.stops.indexOf(stop))] };
}

/**
 * Fixtures from a scene's tags, by kind. The tags are those of hmrsim/fixtures/.
 * @type {Record<string, (fixture: any, tags: string[]) => object>}
 */
export const FROM_TAGS = {
  dock: (dock, tags) => ({ ...dock, docked: after(tags, 'docked:'), queue: after(tags, 'queued:') }),
  door(door, tags) {
    const state = ['open', 'opening', 'closed'].find((word) => tags.includes(word)) ?? door.state;
    return { ...door, state, locked: tags.includes('locked'), jammed: tags.includes('jammed') };
  },
  lift: (lift, tags) => moved(lift, { stop: after(tags, 'at:')[0] ?? lift.stop, to: after(tags, 'to:')[0] ?? null }),
};

function after(tags, prefix) {
  return tags.filter((tag) => tag.startsWith(prefix)).map((tag) => tag.slice(prefix.length));
}

/** Begin or end the effects of a fault, while other faults of its kind at the same subject stay. */
export function applyFault(model, fault, begins, time) {
  const all = [...model.faults.values()].filter((each) => each.fault === fault.fault && each.name !== fault.name);
  if (begins) all.push(fault);
  const { changes } = model.forms.faults[fault.fault] ?? {};
  if (changes === 'jammed') model.setDoor(fault.door, { jammed: all.some(({ door }) => door === fault.door) });
  const robot = model.robots.get(fault.robot);
  if (robot) EFFECTS.get(changes)?.(robot, all.filter((each) => each.robot === fault.robot), { fault, time });
}

/** Update which doors are locked after a lane was closed or opened. */
export function lockDoors(model, lane) {
  for (const { name, lanes } of model.world.doors.values()) {
    if (!lanes.some(({ from, to }) => lane.includes(from) && lane.includes(to))) continue;
    const keys = lanes.flatMap(({ key, from, to }) => [key, `${to}|${from}`]);
    const locked = keys.some((key) => model.closedLanes.get(key)?.includes(`${name} is locked`));
    if (locked !== model.doors.get(name)?.locked) model.setDoor(name, { locked });
  }
}

/** The effects by the value that changes. *all* are the robot's current faults of a kind. */
const EFFECTS = new Map(Object.entries({
  ailments(robot, all, { fault, time }) {
    robot.disable(fault.fault, all.length ? `${robot.name} has broken down at ${spot(robot.poseAt(time))}` : null);
  },
  connected(robot, all) {
    robot.connected = all.length === 0;
  },
  sensors(robot, all) {
    const blind = (name) => all.some(({ sensor }) => (sensor ?? name) === name);
    robot.sensors = robot.sensors.map((sensor) => ({ ...sensor, blind: blind(sensor.name) }));
  },
}));

/** Return a point in the format of the simulator's reasons. */
export function spot(at) {
  const [x, y] = (at ?? [NaN, NaN]).map((each) => +each.toPrecision(6));
  return `(${x}, ${y})`;
}
