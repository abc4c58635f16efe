/** Names of static objects, where there is room for them: places first, waypoints last. */

import { middle } from '../model/motion.js';
import { dockSize } from './fixtures.js';
import { AROUND, Room } from './names.js';
import { faint, fill, polygon, polyline, stroke } from './shapes.js';

const FONT = '11px system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif';
const HEIGHT = 13;
const BOLD = `600 ${FONT}`;
const MAX_LANES = 500; // lanes up to which names avoid them
const NUDGE = 10; // css pixels by which a dock's name may be off center
const CLOSE = 14; // css pixels per meter from which a name may cover a wall
const AWAY = [24, 44]; // css pixels to names that a line leads to
const FEW = 60; // robots up to which names avoid those at rest
const SPARSE = 20; // objects of a kind up to which they have names at any scale
const AGAIN = 1000; // ms after which the robots at rest are looked at again

export class Signs {
  constructor() {
    this.room = new Room();
    this.walls = new Room();
    this.lanes = new Room();
    this.left = this.top = 0; // the corner of the layer on the screen
    this.seen = [0, 0]; // the horizontal range of the uncovered part
    this.widths = new Map();
    this.placed = []; // the names and their boxes on the layer
    this.resting = ''; // the robots at rest when names were placed
    this.looked = -Infinity;
    // A dock at a waypoint of the same name needs it once.
    this.named = new Set();
  }

  draw(c, frame) {
    const { camera, world, measures, colors, layers } = frame;
    this.room.reset(camera.width, camera.height);
    this.walls.reset(camera.width, camera.height);
    this.lanes.reset(camera.width, camera.height);
    this.placed.length = 0;
    for (const place of world.places.values()) drawPin(c, frame, place.at);
    if (!layers.names) return;
    const dock = dockSize(frame);
    this.avoid(frame, dock);
    const close = camera.scale * measures.meter;
    this.named.clear();
    this.kind(c, frame, world.places, colors.place, 9, true, { font: BOLD, leads: true });
    const sparse = ({ size }) => size <= SPARSE;
    this.kind(c, frame, world.docks, colors.muted, dock + 3, sparse(world.docks) || close > 26, { row: true, leads: true });
    this.kind(c, frame, world.doors, colors.door, 7, sparse(world.doors) || close > 40, { leads: sparse(world.doors) });
    this.kind(c, frame, world.lifts, colors.lift, dock + 5, sparse(world.lifts) || close > 14, { leads: sparse(world.lifts) });
    this.kind(c, frame, world.waypoints, colors.muted, 7, sparse(world.waypoints) || close > 38, { leads: sparse(world.waypoints) });
  }

  /** Return whether no name is in a rectangle of the screen. */
  free(left, top, width, height) { return this.room.free(left - this.left, top - this.top, width, height); }

  /** Occupy what names should not cover: walls, pins, docks and resting robots. */
  avoid(frame, dock) {
    const { camera, world, measures, layers, model, clock } = frame;
    const { insets } = camera;
    this.seen = [insets.left, camera.width - insets.right];
    if (layers.walls) for (const { points, solid } of world.walls) this.line(this.walls, camera, points, solid);
    if (layers.lanes && world.lanes.length < MAX_LANES) for (const { a, b } of world.lanes) this.line(this.lanes, camera, [a, b]);
    for (const { at } of world.places.values()) this.spot(camera, at, 0.5);
    for (const { at } of world.docks.values()) this.spot(camera, at, Math.max(1, dock - 6));
    const now = clock.now();
    this.resting = restingOf(model, now);
    for (const robot of model.robots.values()) {
      if (!robot.movesAt(now)) this.spot(camera, robot.poseAt(now), Math.max(5, measures.body * camera.scale));
    }
  }

  /** Return whether other robots are at rest than those that the names avoid; looked at once in a while. */
  stale({ model, clock }, wallMs) {
    if (wallMs - this.looked < AGAIN) return false;
    this.looked = wallMs;
    return restingOf(model, clock.now()) !== this.resting;
  }

  spot(camera, [x, y], radius) {
    this.walls.take(camera.screenX(x) - radius, camera.screenY(y) - radius, 2 * radius, 2 * radius);
  }

  /** Occupy a wall or a lane, on which names are hard to read. */
  line(room, camera, points, closed = false) {
    for (let i = closed ? 0 : 1; i < points.length; i++) {
      const [ax, ay] = points[(i || points.length) - 1];
      const [bx, by] = points[i];
      const [px, py] = [camera.screenX(ax), camera.screenY(ay)];
      const [dx, dy] = [camera.screenX(bx) - px, camera.screenY(by) - py];
      const steps = Math.ceil(Math.hypot(dx, dy) / 6) || 1;
      // Skip lines far out of sight.
      if (steps > 2000) continue;
      for (let k = 0; k <= steps; k++) room.take(px + (dx * k) / steps - 1, py + (dy * k) / steps - 1, 2, 2);
    }
  }

  /**
   * Write names below, above or beside their objects, preferably off walls and lanes.
   *
   * Objects in a *row* have their names close by. If it *leads*, a line leads to a name that has no room close by.
   */
  kind(c, { camera, measures, colors }, things, color, gap, shown, { font = FONT, row = false, leads = false } = {}) {
    if (!shown) return;
    c.font = font;
    c.textAlign = 'center';
    Object.assign(c, {
      textBaseline: 'middle', lineJoin: 'round', lineWidth: 3, strokeStyle: faint(colors.floor, 0.85), fillStyle: color,
    });
    const close = camera.scale * measures.meter > CLOSE;
    for (const thing of things.values()) {
      const { name } = thing;
      const [px, py] = camera.toScreen(spotOf(thing));
      if (!camera.sees(px, py)) continue;
      const key = `${name}@${Math.round(px)},${Math.round(py)}`;
      if (this.named.has(key)) continue;
      const width = this.width(c, font, name);
      const beside = gap + width / 2 + 1;
      const below = gap + HEIGHT / 2;
      // Names at corners are not further away sideways.
      const around = (away) => AROUND.map(([x, y]) => [x * (beside + (y ? 0 : away)), y * (below + away)]);
      const nudged = row ? [[NUDGE, below], [-NUDGE, below], [NUDGE, -below], [-NUDGE, -below]] : [];
      const [under, over, ...sides] = around(0);
      const direct = [under, over, ...nudged, ...sides.splice(0, 2)];
      const apart = row ? [] : [...sides, ...(close ? [[0, below + HEIGHT], [0, -below - HEIGHT]] : [])];
      const far = leads ? AWAY.flatMap(around) : [];
      const [left, right] = this.seen;
      const sight = px >= left && px <= right;
      const near = ([dx]) => !sight || (px + dx - width / 2 >= left && px + dx + width / 2 <= right);
      const find = (spots, ...rooms) => spots.find((spot) => near(spot) && this.fits(px + spot[0], py + spot[1], width, rooms));
      const spot = find(direct, this.walls, this.lanes) ?? find(direct, this.walls) ??
        find(apart, this.walls, this.lanes) ?? find(apart, this.walls) ?? find(far, this.walls) ??
        (close && !row && find([...direct, ...apart]));
      if (!spot) continue;
      const [x0, y0] = [px + spot[0], py + spot[1]];
      const box = [x0 - width / 2 - 2, y0 - HEIGHT / 2, width + 4, HEIGHT];
      this.room.take(...box);
      const line = far.includes(spot);
      this.placed.push({ name, box, line });
      if (line) lead(c, [px, py], [x0, y0], box, color);
      c.strokeText(name, x0, y0);
      c.fillText(name, x0, y0);
      this.named.add(key);
    }
  }

  /** Return whether a name around a point covers no other name, and nothing in some rooms. */
  fits(px, py, width, rooms) {
    const at = [px - width / 2 - 2, py - HEIGHT / 2, width + 4, HEIGHT];
    return this.room.free(...at) && rooms.every((room) => room.free(...at));
  }

  width(c, font, name) {
    const key = font.length + name;
    let width = this.widths.get(key);
    if (width === undefined) this.widths.set(key, (width = c.measureText(name).width));
    return width;
  }
}

/** Draw a line from an object to the edge of its name. */
function lead(c, [px, py], [x, y], [left, top, width, height], color) {
  c.save();
  polyline(c, [[px, py], [Math.min(left + width, Math.max(left, px)), y > py ? top : y < py ? top + height : y]]);
  stroke(c, faint(color, 0.6), 1);
  c.restore();
}

/** Return the robots at rest and their positions; "" if there are too many. */
function restingOf(model, now) {
  if (model.robots.size > FEW) return '';
  const resting = [];
  for (const robot of model.robots.values()) {
    const state = robot.stateAt(now);
    if (state !== 'driving' && state !== 'waiting') resting.push(robot.name, ...robot.poseAt(now).map((each) => each.toFixed(1)));
  }
  return resting.join();
}

/** Return the position of an object's name: of a door in its middle, of a lift at its first stop. */
function spotOf({ at, points }) {
  if (points) return points[0];
  return Array.isArray(at[0]) ? middle(...at) : at;
}

function drawPin(c, { camera, measures, colors }, at) {
  const [px, py] = camera.toScreen(at);
  const size = Math.max(2.5, Math.min(5, 0.12 * measures.meter * camera.scale));
  polygon(c, [[px, py - size], [px + size, py], [px, py + size], [px - size, py]]);
  fill(c, colors.place);
  stroke(c, colors.floor, 1);
}
