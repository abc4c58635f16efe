/** What tells lengths: a grid when zoomed in, and a scale bar. */

import { faint } from './glyphs.js';
import { NAME_FONT } from './sprites.js';

const MIN_GAP = 44; // css pixels between two lines of the grid
const MIN_SCALE = 28; // css pixels a metre from which there is a grid

/** Return 1, 2 or 5 times a power of ten, at least so much. */
function roundLength(least) {
  const power = 10 ** Math.floor(Math.log10(least));
  return power * [1, 2, 5, 10].find((step) => step * power >= least * (1 - 1e-9));
}

export function drawGrid(c, { camera, measures, colours }) {
  if (camera.scale * measures.metre < MIN_SCALE) return;
  const gap = roundLength(MIN_GAP / camera.scale);
  const [x0, y0, x1, y1] = measures.box;
  const left = Math.max(x0, camera.worldX(0));
  const right = Math.min(x1, camera.worldX(camera.width));
  const [a, b] = [camera.worldY(0), camera.worldY(camera.height)];
  const bottom = Math.max(y0, Math.min(a, b));
  const top = Math.min(y1, Math.max(a, b));
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
  c.strokeStyle = faint(colours.line, 0.55);
  c.lineWidth = 1;
  c.stroke();
}

export function drawScaleBar(c, { camera, world, colours }) {
  const length = roundLength(56 / camera.scale);
  const width = length * camera.scale;
  const left = Math.round(camera.width - camera.insets.right - 16 - width) + 0.5;
  const bottom = Math.round(camera.height - camera.insets.bottom - 14) + 0.5;
  const text = world.units === 'm' && length < 1 ? `${Math.round(length * 100)} cm` : `${length} ${world.units}`;
  c.beginPath();
  c.roundRect(left - 8, bottom - 20, width + 16, 28, 5);
  c.fillStyle = faint(colours.background, 0.8);
  c.fill();
  c.beginPath();
  c.moveTo(left, bottom - 4);
  c.lineTo(left, bottom);
  c.lineTo(left + width, bottom);
  c.lineTo(left + width, bottom - 4);
  c.lineWidth = 1.5;
  c.lineCap = 'butt';
  c.lineJoin = 'miter';
  c.strokeStyle = colours.muted;
  c.stroke();
  c.font = NAME_FONT;
  c.textAlign = 'center';
  c.textBaseline = 'alphabetic';
  c.fillStyle = colours.muted;
  c.fillText(text, left + width / 2, bottom - 6);
}
