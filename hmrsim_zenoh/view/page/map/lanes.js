/** Lanes and waypoints: as wide as their capacity, with arrows if one-way, crossed if closed. */

import { middle } from '../model/motion.js';
import { faint, fill, mixed, stroke, trace } from './shapes.js';

const ARROW_EVERY = 64; // css pixels

/** Return the width of a lane on the screen. */
function laneWidth(lane, { camera, measures }) {
  const share = lane.capacity === 1 ? 0.7 : Math.min(2, 0.6 + (lane.capacity ?? 1) * 0.3);
  return Math.min(44, Math.max(2, measures.road * share * camera.scale));
}

function seen(lane, camera, margin) {
  const [[ax, ay], [bx, by]] = [camera.toScreen(lane.a), camera.toScreen(lane.b)];
  return Math.max(ax, bx) > -margin && Math.min(ax, bx) < camera.width + margin &&
    Math.max(ay, by) > -margin && Math.min(ay, by) < camera.height + margin;
}

export function drawLanes(c, frame) {
  const { camera, world, colors, model } = frame;
  const bands = new Map();
  const open = [];
  const closed = [];
  for (const lane of world.lanes) {
    if (!seen(lane, camera, 60)) continue;
    (model.closureOf(lane) === undefined ? open : closed).push(lane);
    const width = Math.round(laneWidth(lane, frame) * 2) / 2;
    if (!bands.has(width)) bands.set(width, []);
    bands.get(width).push(lane);
  }
  c.lineCap = 'round';
  // Mixed instead of transparent, so that overlaps of bands stay invisible.
  const band = mixed(colors.floor, colors.lane, 0.22);
  for (const [width, lanes] of bands) strokeLanes(c, camera, lanes, band, width);
  strokeLanes(c, camera, open, faint(colors.lane, 0.9), 1);
  drawArrows(c, frame, open, colors.lane);
  drawClosed(c, frame, closed);
  drawWaypoints(c, frame);
}

function strokeLanes(c, camera, lanes, color, width, dash) {
  c.beginPath();
  for (const { a, b } of lanes) trace(c, camera, [a, b]);
  stroke(c, color, width, dash);
}

function drawArrows(c, frame, lanes, color) {
  const { camera } = frame;
  c.beginPath();
  for (const lane of lanes) {
    if (!lane.one_way || lane.length * camera.scale < 16) continue;
    const size = Math.min(9, Math.max(3.2, laneWidth(lane, frame) * 0.42));
    const ux = (lane.b[0] - lane.a[0]) / lane.length;
    const uy = ((lane.b[1] - lane.a[1]) / lane.length) * camera.flip;
    const count = Math.max(1, Math.floor((lane.length * camera.scale) / ARROW_EVERY));
    for (let i = 0; i < count; i++) {
      const share = (i + 0.5) / count;
      const x = camera.screenX(lane.a[0] + (lane.b[0] - lane.a[0]) * share) + ux * size * 0.6;
      const y = camera.screenY(lane.a[1] + (lane.b[1] - lane.a[1]) * share) + uy * size * 0.6;
      c.moveTo(x, y);
      c.lineTo(x - ux * size * 1.5 - uy * size * 0.75, y - uy * size * 1.5 + ux * size * 0.75);
      c.lineTo(x - ux * size * 0.95, y - uy * size * 0.95);
      c.lineTo(x - ux * size * 1.5 + uy * size * 0.75, y - uy * size * 1.5 - ux * size * 0.75);
      c.closePath();
    }
  }
  fill(c, color);
}

/** Draw closed lanes dashed, with a cross in the middle unless a locked door is the reason. */
function drawClosed(c, frame, lanes) {
  if (!lanes.length) return;
  const { camera, colors, world, model } = frame;
  const shut = [...world.doors.values()].filter(({ name }) => model.doors.get(name)?.locked);
  const locked = new Set(shut.flatMap((door) => door.lanes));
  c.lineCap = 'butt';
  strokeLanes(c, camera, lanes, colors.lane_closed, 2, [7, 5]);
  c.lineCap = 'round';
  for (const [width, color] of [[6, colors.floor], [2.5, colors.lane_closed]]) {
    c.beginPath();
    for (const lane of lanes) {
      if (locked.has(lane)) continue;
      const [x, y] = camera.toScreen(middle(lane.a, lane.b));
      const size = Math.min(7, Math.max(3, lane.length * camera.scale * 0.3));
      for (const s of [-size, size]) c.moveTo(x - size, y - s), c.lineTo(x + size, y + s);
    }
    stroke(c, color, width);
  }
}

function drawWaypoints(c, { camera, world, measures, colors }) {
  const size = Math.min(4.5, 0.09 * measures.meter * camera.scale);
  if (size < 1.1) return;
  c.beginPath();
  for (const { at } of world.waypoints.values()) {
    const [px, py] = camera.toScreen(at);
    c.moveTo(px + size, py);
    c.arc(px, py, size, 0, 2 * Math.PI);
  }
  fill(c, colors.floor);
  stroke(c, colors.waypoint, Math.min(1.5, size * 0.6));
}
