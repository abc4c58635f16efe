/** Robots and items: their positions on the screen, pictures, state marks and sensor ranges. */

import { circle, faint, fill, stroke } from './shapes.js';
import { HEADINGS, Sprites } from './sprites.js';

/** The positions of robots on the screen, in arrays that are reused from frame to frame. */
export class Poses {
  constructor() {
    this.count = 0; // the number of robots in sight, and of valid entries in the arrays
    this.robots = [];
    this.#makeRoom(0);
    this.goes = []; // whether there is a path ahead
    this.pose = [0, 0, 0];
    this.index = new Map(); // the index of each robot in sight by name
  }

  look(frame, time) {
    const { camera, model, measures } = frame;
    const all = model.robots.size;
    if (this.px.length < all) this.#makeRoom(Math.ceil(all * 1.5) + 16);
    const least = all > 300 ? 4.9 : all > 60 ? 5.5 : 8;
    let count = 0;
    this.index.clear();
    for (const robot of model.robots.values()) {
      const pose = robot.poseAt(time, this.pose);
      const px = camera.screenX(pose[0]);
      const py = camera.screenY(pose[1]);
      const radius = Math.max(least, (robot.radius || measures.body) * camera.scale);
      if (!camera.sees(px, py, radius + 30)) continue;
      this.robots[count] = robot;
      this.px[count] = px;
      this.py[count] = py;
      this.radius[count] = radius;
      this.angle[count] = camera.flip * pose[2];
      this.goes[count] = robot.route.length > 0 && (robot.waiting !== null || robot.movesAt(time));
      this.index.set(robot.name, count);
      count++;
    }
    this.robots.length = count;
    this.count = count;
  }

  /** Positions and radii are css pixels, angles radians clockwise, as the canvas turns. */
  #makeRoom(count) { for (const key of ['px', 'py', 'radius', 'angle']) this[key] = new Float32Array(count); }

  /** Return x, y and radius of a robot on the screen, or null if it is out of sight. */
  where(name) {
    const i = this.index.get(name);
    return i === undefined ? null : [this.px[i], this.py[i], this.radius[i]];
  }
}

/** Return whether any robot moves between two times. */
export function anyRobotMoves(model, before, now) {
  const least = Math.min(before, now);
  for (const robot of model.robots.values()) if (robot.ends > least) return true;
  return false;
}

/** Return whether a robot is selected, followed or below the pointer. */
export function isChosen({ selected, follow, hovered }, { name }) {
  return name === selected || name === follow || name === hovered;
}

const SENSORS_CROWD = 40; // robots in sight above which only chosen ones' sensors are shown

export function drawSensors(c, frame, poses) {
  const { camera, colors } = frame;
  const all = poses.count <= SENSORS_CROWD;
  for (let i = 0; i < poses.count; i++) {
    const robot = poses.robots[i];
    const chosen = isChosen(frame, robot);
    if (!robot.sensors.length || !(all || chosen)) continue;
    for (const sensor of robot.sensors) drawReach(c, frame, sensor, poses, i, chosen);
    if (!robot.detections.length) continue;
    c.beginPath();
    for (const { at } of robot.detections) {
      const [px, py] = camera.toScreen(at);
      c.moveTo(poses.px[i], poses.py[i]);
      c.lineTo(px, py);
      c.moveTo(px + 9, py);
      c.arc(px, py, 9, 0, 2 * Math.PI);
    }
    stroke(c, colors.sensor, 1.5, [2, 3]);
  }
}

function drawReach(c, { camera, colors }, sensor, poses, i, chosen) {
  const radius = sensor.range * camera.scale;
  if (!(radius > 3)) return;
  const [px, py] = [poses.px[i], poses.py[i]];
  const half = sensor.field_of_view ? sensor.field_of_view / 2 : Math.PI;
  const heading = poses.angle[i];
  c.beginPath();
  if (half < Math.PI) c.moveTo(px, py);
  c.arc(px, py, radius, heading - half, heading + half);
  c.closePath();
  fill(c, faint(colors.sensor, sensor.blind ? 0 : chosen ? 0.16 : 0.07));
  if (sensor.blind) stroke(c, colors.fault, 1, [4, 4]);
  else stroke(c, faint(colors.sensor, chosen ? 0.8 : 0.4), 1);
}

const FEW = 60; // robots in sight
const CROWD = 160; // robots in sight above which small ones have no battery
const SMALL = 16; // css pixels of radius below which headings are rounded
const PLAIN = 9; // css pixels of radius below which many robots have only marks of problems
const DOT = 5; // css pixels of radius below which a robot has no marks

export function drawItems(c, frame, sprites) {
  const sprite = sprites.item(itemSize(frame));
  for (const { at, carrier } of frame.model.items.values()) {
    if (carrier || !at || !inSight(frame.camera, at)) continue;
    stamp(c, sprite, ...frame.camera.toScreen(at));
  }
}

export function drawRobots(c, frame, sprites, poses, time) {
  const { ratio, world, selected } = frame;
  for (let i = 0; i < poses.count; i++) {
    const [robot, radius, angle] = [poses.robots[i], poses.radius[i], poses.angle[i]];
    const size = Sprites.size(radius);
    const small = radius < SMALL;
    // Whole steps, also for negative angles.
    const heading = small ? Math.round((angle * HEADINGS) / (2 * Math.PI)) & (HEADINGS - 1) : 0;
    const sprite = sprites.robot(sprites.look(robot.type, world), robot.flies, robot.stateAt(time), size, heading);
    const width = (sprite.width * radius) / Sprites.radius(size);
    if (small) {
      c.drawImage(sprite.image, poses.px[i] - width / 2, poses.py[i] - width / 2, width, width);
      continue;
    }
    const cos = Math.cos(angle) * ratio;
    const sin = Math.sin(angle) * ratio;
    c.setTransform(cos, sin, -sin, cos, poses.px[i] * ratio, poses.py[i] * ratio);
    c.drawImage(sprite.image, -width / 2, -width / 2, width, width);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
  }
  drawMarks(c, frame, sprites, poses, time);
  const i = poses.index.get(selected);
  if (i !== undefined) drawHalo(c, frame, poses.px[i], poses.py[i], poses.radius[i]);
}

/** Draw the marks of robots that do not turn: state, battery and held items. */
function drawMarks(c, frame, sprites, poses, time) {
  for (let i = 0; i < poses.count; i++) {
    const [robot, radius, px, py] = [poses.robots[i], poses.radius[i], poses.px[i], poses.py[i]];
    if (radius < DOT) continue;
    const side = Math.min(9, Math.max(5, Math.round(radius * 0.45)));
    const state = robot.stateAt(time);
    const minor = state === 'busy' && radius < PLAIN && poses.count > FEW;
    const badge = minor ? null : sprites.badge(state, side);
    if (badge) stamp(c, badge, px + radius * 0.78, py - radius * 0.78);
    if (robot.holds.length) {
      // On its back, opposite the wedge.
      const item = sprites.item(Math.round(Math.min(30, Math.max(6, radius * 0.6))));
      const back = radius * 0.3;
      stamp(c, item, px - back * Math.cos(poses.angle[i]), py - back * Math.sin(poses.angle[i]));
    }
    if (robot.battery && (radius >= 10 || (poses.count <= CROWD && radius >= 7))) {
      const tenths = Math.max(0, Math.min(10, Math.round(robot.battery.percentage * 10)));
      stamp(c, sprites.battery(tenths, Math.round(Math.min(36, radius * 1.5))), px, py + radius + 4);
    }
  }
}

/** The side of an item on the screen. */
export function itemSize({ camera, model, measures }) {
  return Math.round(Math.min(14, Math.max(model.items.size > 40 ? 3.5 : 7, 0.22 * measures.meter * camera.scale)));
}

/** Return whether a point of the world is on the screen, or near it. */
export function inSight(camera, [x, y]) { return camera.sees(camera.screenX(x), camera.screenY(y), 20); }

/** Copy a picture around a point, onto whole pixels so that it stays sharp. */
export function stamp(c, sprite, px, py) {
  const { image, width, height } = sprite;
  c.drawImage(image, Math.round(px - width / 2), Math.round(py - height / 2), width, height);
}

function drawHalo(c, { colors }, px, py, radius) {
  for (const [width, color] of [[5, colors.floor], [2.5, colors.selected]]) {
    circle(c, px, py, radius + 4);
    stroke(c, color, width);
  }
}
