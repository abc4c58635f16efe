/** Driven trails, fading, and paths ahead, dashed, with a flag at the end; one canvas path for each color. */

import { isChosen } from './robot_layer.js';
import { circle, faint, fill, polyline, stroke } from './shapes.js';

const FADES = [0.16, 0.32, 0.6]; // opacity of the oldest part, the middle, the newest
const POINTS = 2400; // points of all driven trails together
// Long dashed lines are slow to draw: with more robots in sight, less is shown of robots that are not selected.
const DASHED = 40; // robots in sight up to which their paths are dashed
const WHOLE = 60; // up to which they are shown whole, with flags
const CROWD = 400; // up to which the next points are shown, and fading trails
const NEXT = 2;
const ALL = 400;
const DASHES = [6, 5];

/** Draw the driven trails of the robots in sight. */
export function drawDriven(c, frame, poses) {
  const { colors } = frame;
  const crowded = poses.count > CROWD;
  const each = Math.max(2, Math.floor(POINTS / Math.max(1, poses.count)));
  Object.assign(c, { lineJoin: crowded ? 'bevel' : 'round', lineCap: crowded ? 'butt' : 'round' });
  for (let part = crowded ? 2 : 0; part < 3; part++) {
    c.beginPath();
    for (let i = 0; i < poses.count; i++) traceDriven(c, frame, poses, i, part, each);
    stroke(c, faint(colors.driven, FADES[part]), poses.count > WHOLE ? 1.5 : 2.5);
  }
}

/** Trace a third of a robot's trail. */
function traceDriven(c, frame, poses, i, part, each) {
  const { camera } = frame;
  const { driven } = poses.robots[i];
  if (!driven.length) return;
  const first = Math.max(0, driven.length - (isChosen(frame, poses.robots[i]) ? ALL : each));
  const from = first + Math.floor(((driven.length - first) * part) / 3);
  const to = first + Math.floor(((driven.length - first) * (part + 1)) / 3);
  if (from === to && part < 2) return;
  c.moveTo(...camera.toScreen(driven[from]));
  for (let k = from + 1; k <= to && k < driven.length; k++) c.lineTo(...camera.toScreen(driven[k]));
  if (part === 2) c.lineTo(poses.px[i], poses.py[i]);
}

/** Draw the paths ahead of the robots in sight. */
export function drawAhead(c, frame, poses) {
  const { colors } = frame;
  const whole = poses.count <= WHOLE;
  const dashed = poses.count <= DASHED;
  Object.assign(c, { lineJoin: 'round', lineCap: 'butt' });
  c.beginPath();
  for (let i = 0; i < poses.count && poses.count <= CROWD; i++) {
    if (!isChosen(frame, poses.robots[i])) traceRoute(c, frame, poses, i, whole ? ALL : NEXT);
  }
  stroke(c, faint(colors.ahead, dashed ? 0.95 : whole ? 0.6 : 0.4), whole ? 2 : 1, dashed ? DASHES : undefined);
  for (let i = 0; i < poses.count; i++) {
    if (!isChosen(frame, poses.robots[i])) continue;
    c.beginPath();
    traceRoute(c, frame, poses, i, ALL);
    stroke(c, colors.ahead, 3, DASHES);
  }
  for (let i = 0; i < poses.count; i++) {
    const { route } = poses.robots[i];
    if (!poses.goes[i] || !(whole || isChosen(frame, poses.robots[i]))) continue;
    drawFlag(c, frame, route[route.length - 1], colors.ahead);
  }
}

function traceRoute(c, { camera }, poses, i, most) {
  if (!poses.goes[i]) return;
  const { route } = poses.robots[i];
  c.moveTo(poses.px[i], poses.py[i]);
  for (let k = 0; k < route.length && k < most; k++) c.lineTo(...camera.toScreen(route[k]));
}

/** Draw a flag that stands on a point of the world. */
function drawFlag(c, { camera, colors }, at, color, size = 13) {
  const [px, py] = camera.toScreen(at);
  c.beginPath();
  for (const [x, y] of [[0, 0], [0, 1.25], [0.8, 0.92], [0, 0.55]]) c.lineTo(px + size * x, py - size * y);
  c.lineJoin = 'round';
  stroke(c, colors.floor, 4);
  stroke(c, color, 1.6);
  fill(c, color);
  circle(c, px, py, 2.4);
  c.fill();
}

/** Draw the preview of a goal: a target, a flag and a line from the chosen robot. */
export function drawPreview(c, frame, from) {
  const { camera, colors, goalPreview } = frame;
  const [px, py] = camera.toScreen(goalPreview);
  if (from) {
    polyline(c, [from, [px, py]]);
    stroke(c, colors.selected, 1.5, [3, 4]);
  }
  circle(c, px, py, 11);
  fill(c, faint(colors.selected, 0.18));
  stroke(c, colors.selected, 1.5);
  drawFlag(c, frame, goalPreview, colors.selected, 18);
}
