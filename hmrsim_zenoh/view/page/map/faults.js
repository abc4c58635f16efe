/** What goes wrong: marks where a fault is, and the circles of robots that wait for each other. */

import { drawWarning } from './glyphs.js';

/**
 * Mark faults at lanes, doors and robots; *where* tells where a robot is on the screen, or null.
 *
 * @param {CanvasRenderingContext2D} c
 * @param {import('./view.js').Frame} frame
 * @param {(name: string) => number[]|null} where
 */
export function drawFaults(c, frame, where) {
  const { colours } = frame;
  for (const fault of frame.model.faults.values()) {
    const at = spotOf(fault, frame, where);
    if (at) drawWarning(c, at[0], at[1], 8, colours.fault, colours.floor);
  }
}

function spotOf(fault, { camera, world, model }, where) {
  if (fault.robot) {
    const at = where(fault.robot);
    return at && [at[0] - 0.8 * at[2] - 3, at[1] - 0.8 * at[2] - 2];
  }
  const between = ([a, b]) => [camera.screenX((a[0] + b[0]) / 2), camera.screenY((a[1] + b[1]) / 2)];
  const door = fault.door && model.doors.get(fault.door);
  if (door) return between(door.at);
  if (!Array.isArray(fault.lane)) return null;
  const lane = world.lanesByKey.get(fault.lane.join('|')) ?? world.lanesByKey.get([...fault.lane].reverse().join('|'));
  return lane ? between([lane.a, lane.b]) : null;
}

/** Link the robots of each deadlock, in the order in which one waits for the next. */
export function drawDeadlocks(c, frame, where) {
  const { colours, model } = frame;
  if (!model.deadlocks.length) return;
  for (const [width, colour] of [[6, colours.floor], [3, colours.fault]]) {
    c.beginPath();
    for (const { robots } of model.deadlocks) {
      const spots = robots.map(where).filter(Boolean);
      spots.forEach((at, i) => link(c, at, spots[(i + 1) % spots.length]));
    }
    c.lineWidth = width;
    c.lineCap = 'round';
    c.strokeStyle = colour;
    c.stroke();
  }
}

/** Trace an arc from robot to robot, bent to one side so that those of two don't lie on each other. */
function link(c, [ax, ay, ar], [bx, by, br]) {
  const length = Math.hypot(bx - ax, by - ay);
  if (length < 1) return;
  const ux = (bx - ax) / length;
  const uy = (by - ay) / length;
  const bend = Math.min(40, length * 0.28);
  const sx = ax + ux * (ar + 2);
  const sy = ay + uy * (ar + 2);
  const ex = bx - ux * (br + 4);
  const ey = by - uy * (br + 4);
  const mx = (ax + bx) / 2 + uy * bend;
  const my = (ay + by) / 2 - ux * bend;
  c.moveTo(sx, sy);
  c.quadraticCurveTo(mx, my, ex, ey);
  const tilt = Math.atan2(ey - my, ex - mx);
  for (const side of [-1, 1]) {
    c.moveTo(ex, ey);
    c.lineTo(ex - 9 * Math.cos(tilt + side * 0.5), ey - 9 * Math.sin(tilt + side * 0.5));
  }
}
