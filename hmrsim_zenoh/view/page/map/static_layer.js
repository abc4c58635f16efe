/**
 * The layer of static objects, on a canvas that is larger than the screen. It is redrawn when the theme, a fixture or the
 * scale changes. While the camera only moves, the canvas is shifted.
 */

import { drawFixtures } from './fixtures.js';
import { drawLanes } from './lanes.js';
import { faint, fill, plate, polyline, stroke, trace } from './shapes.js';
import { Signs } from './signs.js';
import { NAME_FONT, SOFTWARE } from './sprites.js';

const METER = { m: 1, px: 80 }; // units of the world per meter
const ROAD = { m: 0.5, px: 18 }; // the width of a lane
const BODY = { m: 0.25, px: 12 }; // the radius of a robot without a footprint

/** Return the sizes of a world, in its unit, and its box. */
export function measuresOf({ units, bounds, extent }) {
  return { meter: METER[units], road: ROAD[units], body: BODY[units], box: bounds ?? around(extent, METER[units]) };
}

/** Return a box with a margin. */
function around([x0, y0, x1, y1], meter) {
  const margin = Math.max(meter * 0.8, 0.03 * Math.max(x1 - x0, y1 - y0));
  return [x0 - margin, y0 - margin, x1 + margin, y1 + margin];
}

const MIN_GAP = 44; // css pixels between two lines of the grid
const MIN_SCALE = 28; // css pixels per meter from which there is a grid

/** Return the least 1, 2 or 5 times a power of ten that is large enough. */
function roundLength(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * [1, 2, 5, 10].find((step) => step * power >= least * (1 - 1e-9));
}

function drawGrid(c, { camera, measures, colors }) {
  if (camera.scale * measures.meter < MIN_SCALE) return;
  const gap = roundLength(MIN_GAP / camera.scale);
  const [x0, y0, x1, y1] = measures.box;
  const [left, right] = [Math.max(x0, camera.worldX(0)), Math.min(x1, camera.worldX(camera.width))];
  const [a, b] = [camera.worldY(0), camera.worldY(camera.height)];
  const [bottom, top] = [Math.max(y0, Math.min(a, b)), Math.min(y1, Math.max(a, b))];
  c.beginPath();
  for (let x = Math.ceil(left / gap) * gap; x <= right; x += gap) {
    const px = Math.round(camera.screenX(x)) + 0.5;
    c.moveTo(px, camera.screenY(bottom));
    c.lineTo(px, camera.screenY(top));
  }
  for (let y = Math.ceil(bottom / gap) * gap; y <= top; y += gap) {
    const py = Math.round(camera.screenY(y)) + 0.5;
    c.moveTo(camera.screenX(left), py);
    c.lineTo(camera.screenX(right), py);
  }
  stroke(c, faint(colors.line, 0.55), 1);
}

export function drawScaleBar(c, { camera, world, colors }) {
  const length = roundLength(56 / camera.scale);
  const width = length * camera.scale;
  const left = Math.round(camera.width - camera.insets.right - 16 - width) + 0.5;
  const bottom = Math.round(camera.height - camera.insets.bottom - 14) + 0.5;
  const text = world.units === 'm' && length < 1 ? `${Math.round(length * 100)} cm` : `${length} ${world.units}`;
  plate(c, left - 8, bottom - 20, width + 16, 28, 5);
  fill(c, faint(colors.background, 0.8));
  polyline(c, [[left, bottom - 4], [left, bottom], [left + width, bottom], [left + width, bottom - 4]]);
  Object.assign(c, { lineCap: 'butt', lineJoin: 'miter' });
  stroke(c, colors.muted, 1.5);
  Object.assign(c, { font: NAME_FONT, textAlign: 'center', textBaseline: 'alphabetic', fillStyle: colors.muted });
  c.fillText(text, left + width / 2, bottom - 6);
}

export const MARGIN = 128; // css pixels around the screen that are also drawn

export class StaticLayer {
  constructor(canvas) {
    this.canvas = canvas;
    this.c = canvas.getContext('2d', { alpha: false, willReadFrequently: SOFTWARE });
    this.signs = new Signs();
    this.camera = null; // the camera of the last drawing, with the margin
  }

  /** Show the camera's view by shifting the canvas. @returns {boolean} Whether that was possible. */
  shift({ camera, ratio }) {
    const drawn = this.camera;
    if (!drawn || drawn.scale !== camera.scale) return false;
    const dx = Math.round((drawn.x - camera.x) * camera.scale * ratio) / ratio;
    const dy = Math.round(camera.flip * (drawn.y - camera.y) * camera.scale * ratio) / ratio;
    if (!(Math.abs(dx) <= MARGIN && Math.abs(dy) <= MARGIN)) return false;
    this.place(dx, dy);
    return true;
  }

  place(dx, dy) {
    this.canvas.style.transform = `translate(${dx - MARGIN}px, ${dy - MARGIN}px)`;
    Object.assign(this.signs, { left: dx - MARGIN, top: dy - MARGIN });
  }

  draw(view) {
    const camera = this.camera = view.camera.widened(MARGIN);
    const frame = Object.create(view, { camera: { value: camera } });
    const { c } = this;
    const { world, colors, layers, ratio } = frame;
    this.place(0, 0);
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = colors.background;
    c.fillRect(0, 0, camera.width, camera.height);
    if (!world) return;
    drawFloor(c, frame);
    drawGrid(c, frame);
    if (layers.lanes) drawLanes(c, frame);
    if (layers.walls) drawWalls(c, frame);
    drawFixtures(c, frame);
    this.signs.draw(c, frame);
  }
}

function drawFloor(c, { camera, world, measures, colors }) {
  const [x0, y0, x1, y1] = measures.box;
  const box = [camera.screenX(x0), Math.min(camera.screenY(y0), camera.screenY(y1)), (x1 - x0) * camera.scale, (y1 - y0) * camera.scale];
  c.fillStyle = colors.floor;
  c.fillRect(...box);
  const [left, top, width, height] = box.map(Math.round);
  c.beginPath();
  c.rect(left - 0.5, top - 0.5, width + 1, height + 1);
  stroke(c, colors.line, 1, world.bounds ? [] : [4, 4]);
}

/** Walls and obstacles, in world coordinates so that one path holds all of them. */
function drawWalls(c, { camera, world, measures, colors }) {
  const thick = Math.max(1.5, Math.min(5.5, 0.1 * measures.meter * camera.scale));
  c.lineJoin = 'round';
  c.lineCap = 'round';
  c.beginPath();
  for (const { points, solid } of world.walls) if (solid) trace(c, camera, points, true);
  fill(c, colors.solid);
  stroke(c, colors.wall, Math.max(1, thick * 0.5));
  c.beginPath();
  for (const { points, solid } of world.walls) if (!solid) trace(c, camera, points);
  stroke(c, colors.wall, thick);
}
