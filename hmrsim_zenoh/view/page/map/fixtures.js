/** Docks, doors and lifts in their current state, marks of faults, causes of waits, and circles of deadlocked robots. */

import { middle } from '../model/motion.js';
import { isChosen } from './robot_layer.js';
import { drawBadge, drawGlyph, drawWarning, faint, fill, plate, polyline, stroke, trace } from './shapes.js';

export function drawFixtures(c, frame) {
  const { model } = frame;
  for (const lift of model.lifts.values()) drawLift(c, frame, lift);
  drawDocks(c, frame);
  for (const door of model.doors.values()) drawDoor(c, frame, door);
}

/** The share of a door's half that a leaf closes. */
const LEAF = { open: 0.12, opening: 0.3, closed: 0.5 };

/** Half the side of a dock on the screen. */
export function dockSize({ camera, measures }) {
  return Math.min(26, Math.max(3, 0.45 * measures.meter * camera.scale));
}

function drawDocks(c, frame) {
  const { camera, model, colors } = frame;
  const size = dockSize(frame);
  for (const dock of model.docks.values()) {
    const [px, py] = camera.toScreen(dock.at);
    if (!camera.sees(px, py, 40)) continue;
    const color = dock.charges ? colors.charger : colors.dock;
    const taken = dock.docked.length;
    plate(c, px - size, py - size, 2 * size, 2 * size, size * 0.3);
    fill(c, faint(color, taken ? 0.3 : 0.1));
    stroke(c, color, size < 6 ? 1 : 1.5, !taken && size >= 6 ? [4, 3] : undefined);
    if (size < 7) continue;
    if (dock.charges && !taken) drawGlyph(c, 'bolt', px, py, size * 0.6, faint(color, 0.85));
    if (dock.capacity > 1) {
      c.fillStyle = color;
      Object.assign(c, { font: '600 10px system-ui, sans-serif', textAlign: 'right', textBaseline: 'bottom' });
      c.fillText(`${taken}/${dock.capacity}`, px + size - 3, py + size - 1);
    }
  }
}

/** Draw a door as a hollow bar, unlike a wall; an open one has only leaves at the jambs. */
function drawDoor(c, { camera, measures, colors }, door) {
  const [a, b] = door.at;
  const [ax, ay] = camera.toScreen(a);
  const [dx, dy] = [camera.screenX(b[0]) - ax, camera.screenY(b[1]) - ay];
  const thick = Math.max(4, Math.min(9, 0.2 * measures.meter * camera.scale));
  const leaf = LEAF[door.state] ?? 0.5;
  const color = door.locked ? colors.fault : colors.door;
  const bars = [[thick + 2, colors.floor], [thick, color], [thick - 2.5, door.locked ? color : colors.floor]];
  c.lineCap = 'butt';
  for (const [width, shade] of bars) {
    // The hollow part is shorter, so that the bar is closed at its ends.
    const end = width < thick ? 1.25 / (Math.hypot(dx, dy) || 1) : 0;
    c.beginPath();
    for (const [from, to] of leaf === 0.5 ? [[end, 1 - end]] : [[end, leaf - end], [1 - leaf + end, 1 - end]]) {
      c.moveTo(ax + dx * from, ay + dy * from);
      c.lineTo(ax + dx * to, ay + dy * to);
    }
    stroke(c, shade, width);
  }
  if (leaf < 0.5) {
    // A thin line between the leaves marks the door.
    polyline(c, [leaf, 1 - leaf].map((share) => [ax + dx * share, ay + dy * share]));
    stroke(c, color, 1, [2, 3]);
  }
  if (!door.locked || Math.hypot(dx, dy) < 14) return;
  drawBadge(c, 'lock', ax + dx / 2, ay + dy / 2, 7, colors.fault, colors.floor);
}

/** Draw a lift as a shaft through its stops, with the cabin and a badge at the destination. */
function drawLift(c, { camera, measures, colors }, lift) {
  const size = Math.min(30, Math.max(4, 0.55 * measures.meter * camera.scale));
  c.beginPath();
  trace(c, camera, lift.points);
  stroke(c, colors.lift, 1.5, [2, 4]);
  for (const [i, stop] of lift.stops.entries()) {
    const [px, py] = camera.toScreen(lift.points[i]);
    const here = stop === lift.stop;
    plate(c, px - size, py - size, 2 * size, 2 * size, 2);
    fill(c, faint(colors.lift, here ? 0.35 : 0.08));
    stroke(c, colors.lift, here ? 2 : 1, here ? undefined : [3, 3]);
    if (stop !== lift.to || size <= 5) continue;
    drawBadge(c, 'dots', px, py, Math.min(8, size * 0.6), colors.lift, colors.floor);
  }
}

/** Mark faults at lanes, doors and robots; *where* returns the position of a robot on the screen, or null. */
export function drawFaults(c, frame, where) {
  const { colors } = frame;
  for (const fault of frame.model.faults.values()) {
    const at = spotOf(fault, frame, where);
    if (at) drawWarning(c, at[0], at[1], 8, colors.fault, colors.floor);
  }
}

function spotOf(fault, { camera, world, model }, where) {
  if (fault.robot) {
    const at = where(fault.robot);
    return at && [at[0] - 0.8 * at[2] - 3, at[1] - 0.8 * at[2] - 2];
  }
  const door = fault.door && model.doors.get(fault.door);
  if (door) return camera.toScreen(middle(...door.at));
  if (!Array.isArray(fault.lane)) return null;
  const lane = world.lanesByKey.get(fault.lane.join('|')) ?? world.lanesByKey.get([...fault.lane].reverse().join('|'));
  return lane ? camera.toScreen(middle(lane.a, lane.b)) : null;
}

const CROWD = 60; // robots in sight above which only the causes of chosen robots are shown

/** Draw an arrow from each robot that is held up to each robot that holds it up, thick for a chosen robot's causes. */
export function drawCauses(c, frame, poses, where) {
  const { model, palette } = frame;
  const color = palette.states.waiting;
  const traced = new Set();
  for (const robot of poses.robots) if (isChosen(frame, robot)) addCauses(robot, model, traced);
  for (const thick of [false, true]) {
    c.beginPath();
    for (const robot of thick ? traced : poses.count <= CROWD ? poses.robots : []) {
      const from = traced.has(robot) === thick ? where(robot.name) : null;
      for (const name of from ? robot.heldBy(model) : []) {
        const to = where(name);
        if (to) link(c, from, to);
      }
    }
    c.lineCap = 'round';
    stroke(c, thick ? color : faint(color, 0.7), thick ? 3 : 1.5);
  }
}

/** Add a robot and all robots that hold it up, directly or not, to a set. */
function addCauses(robot, model, traced) {
  if (!robot || traced.has(robot)) return;
  traced.add(robot);
  for (const name of robot.heldBy(model)) addCauses(model.robots.get(name), model, traced);
}

/** Link the robots of each deadlock, each to the one that it waits for. */
export function drawDeadlocks(c, frame, where) {
  const { colors, model } = frame;
  if (!model.deadlocks.length) return;
  for (const [width, color] of [[6, colors.floor], [3, colors.fault]]) {
    c.beginPath();
    for (const { robots } of model.deadlocks) {
      const spots = robots.map(where).filter(Boolean);
      spots.forEach((at, i) => link(c, at, spots[(i + 1) % spots.length]));
    }
    c.lineCap = 'round';
    stroke(c, color, width);
  }
}

/** Trace an arc from robot to robot, bent to one side so that mutual arcs do not overlap. */
function link(c, [ax, ay, ar], [bx, by, br]) {
  const length = Math.hypot(bx - ax, by - ay);
  if (length < 1) return;
  const [ux, uy] = [(bx - ax) / length, (by - ay) / length];
  const bend = Math.min(40, length * 0.28);
  const [ex, ey] = [bx - ux * (br + 4), by - uy * (br + 4)];
  const [mx, my] = [(ax + bx) / 2 + uy * bend, (ay + by) / 2 - ux * bend];
  c.moveTo(ax + ux * (ar + 2), ay + uy * (ar + 2));
  c.quadraticCurveTo(mx, my, ex, ey);
  const tilt = Math.atan2(ey - my, ex - mx);
  for (const side of [-1, 1]) {
    c.moveTo(ex, ey);
    c.lineTo(ex - 9 * Math.cos(tilt + side * 0.5), ey - 9 * Math.sin(tilt + side * 0.5));
  }
}
