/** What faults do to robots and doors: events only say that they begin and end, forms what each changes. */

/**
 * @typedef {import('./state.js').Fault} Fault
 * @typedef {import('./model.js').Model} Model
 */

/**
 * Let a fault have its effects, or cease to have them; the others of its kind at the same subject stay.
 * @param {Model} model
 * @param {Fault} fault
 * @param {boolean} begins
 * @param {number} time
 */
export function applyFault(model, fault, begins, time) {
  const all = [...model.faults.values()].filter((each) => each.fault === fault.fault && each.name !== fault.name);
  if (begins) all.push(fault);
  const { changes } = model.forms.faults[fault.fault] ?? {};
  if (changes === 'jammed') model.setDoor(fault.door, { jammed: all.some(({ door }) => door === fault.door) });
  const robot = model.robots.get(fault.robot);
  if (!robot) return;
  EFFECTS.get(changes)?.(robot, all.filter((each) => each.robot === fault.robot), { fault, begins, time });
}

/**
 * Have doors be locked or not, whose lanes were closed or opened.
 * @param {Model} model
 * @param {string[]} lane
 */
export function lockDoors(model, lane) {
  for (const { name, lanes } of model.world.doors.values()) {
    if (!lanes.some(({ from, to }) => lane.includes(from) && lane.includes(to))) continue;
    const keys = lanes.flatMap(({ from, to }) => [`${from}|${to}`, `${to}|${from}`]);
    const locked = keys.some((key) => model.closedLanes.get(key)?.includes(`${name} is locked`));
    if (locked !== model.doors.get(name)?.locked) model.setDoor(name, { locked });
  }
}

/** By what changes: *all* are those that a robot has now. */
const EFFECTS = new Map(Object.entries({
  ailments(robot, all, { fault, time }) {
    const [x, y] = robot.poseAt(time).map((each) => +each.toPrecision(6));
    robot.disable(fault.fault, all.length ? `${robot.name} has broken down at (${x}, ${y})` : null);
  },
  connected(robot, all) {
    robot.connected = all.length === 0;
  },
  sensors(robot, all) {
    const blind = (name) => all.some(({ sensor }) => (sensor ?? name) === name);
    robot.sensors = robot.sensors.map((sensor) => ({ ...sensor, blind: blind(sensor.name) }));
  },
  speed(robot, _all, { fault, begins }) {
    if (robot.speed && fault.factor > 0) robot.speed *= begins ? fault.factor : 1 / fault.factor;
  },
}));
