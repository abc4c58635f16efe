/**
 * What stands still, on a canvas of its own that is larger than the screen: drawn anew when the theme, a fixture or the
 * scale changes; while the camera only moves, the canvas is shifted.
 */

import { drawFixtures } from './fixtures.js';
import { drawGrid } from './grid.js';
import { drawLanes } from './lanes.js';
import { Signs } from './signs.js';

export const MARGIN = 128; // css pixels around the screen that are drawn, too

export class StaticLayer {
  /** @param {HTMLCanvasElement} canvas */
  constructor(canvas) {
    this.canvas = canvas;
    this.c = canvas.getContext('2d', { alpha: false });
    this.signs = new Signs();
    /** The camera as it was when it was drawn, with the margin. @type {import('./camera.js').Camera|null} */
    this.camera = null;
  }

  /**
   * Show what a camera sees by shifting what is drawn already.
   *
   * @param {import('./view.js').Frame} frame
   * @returns {boolean} whether that was possible
   */
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

  /**
   * @param {import('./view.js').Frame} view
   */
  draw(view) {
    this.camera = view.camera.widened(MARGIN);
    const frame = Object.create(view, { camera: { value: this.camera } });
    this.place(0, 0);
    this.paint(frame);
  }

  paint(frame) {
    const { c } = this;
    const { camera, world, colours, layers, ratio } = frame;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.fillStyle = colours.background;
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

function drawFloor(c, { camera, world, measures, colours }) {
  const [x0, y0, x1, y1] = measures.box;
  const left = camera.screenX(x0);
  const top = Math.min(camera.screenY(y0), camera.screenY(y1));
  const width = (x1 - x0) * camera.scale;
  const height = (y1 - y0) * camera.scale;
  c.fillStyle = colours.floor;
  c.fillRect(left, top, width, height);
  c.strokeStyle = colours.line;
  c.lineWidth = 1;
  c.setLineDash(world.bounds ? [] : [4, 4]);
  c.strokeRect(Math.round(left) - 0.5, Math.round(top) - 0.5, Math.round(width) + 1, Math.round(height) + 1);
  c.setLineDash([]);
}

/** Walls and obstacles, in world coordinates so that one path holds all of them. */
function drawWalls(c, { camera, world, measures, colours }) {
  const thick = Math.max(1.5, Math.min(5.5, 0.1 * measures.metre * camera.scale));
  c.lineJoin = 'round';
  c.lineCap = 'round';
  c.beginPath();
  for (const { points, solid } of world.walls) if (solid) trace(c, camera, points, true);
  c.fillStyle = colours.solid;
  c.fill();
  c.lineWidth = Math.max(1, thick * 0.5);
  c.strokeStyle = colours.wall;
  c.stroke();
  c.beginPath();
  for (const { points, solid } of world.walls) if (!solid) trace(c, camera, points, false);
  c.lineWidth = thick;
  c.stroke();
}

function trace(c, camera, points, closed) {
  for (let i = 0; i < points.length; i++) {
    const px = camera.screenX(points[i][0]);
    const py = camera.screenY(points[i][1]);
    if (i) c.lineTo(px, py);
    else c.moveTo(px, py);
  }
  if (closed) c.closePath();
}
