/** Pictures that are drawn once and copied often: bodies, badges, batteries and names. */

import { STATE_GLYPHS, circle, drawBadge, drawBody, drawSmall, faint, fill, inkOn, lookOf, mixed, plate, stroke } from './shapes.js';
import { STATES } from '../model/robot.js';

/** Whether the browser draws by software, where a GPU's way of drawing canvases is many times as slow. */
export const SOFTWARE = drawsBySoftware();
const MAX_SPRITES = 2000; // cached pictures
export const HEADINGS = 64; // of small robots' pictures, as turning a picture is slow and copying it is not
const STEP = 1.08; // ratio of one cached size to the next
export const NAME_FONT = '500 11px system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif';
const NAME_HEIGHT = 16;
const HEAD = 5.5; // css pixels of radius below which a robot is an arrowhead

/** @typedef {{image: ImageBitmap, width: number, height: number}} Sprite in css pixels */

export class Sprites {
  constructor(palette) {
    this.palette = palette;
    this.theme = 'light';
    this.ratio = 1;
    this.kept = new Map();
    this.looks = new Map(); // looks by type
    this.measure = new OffscreenCanvas(1, 1).getContext('2d');
    this.measure.font = NAME_FONT;
  }

  /** Clear the cache, as after a change of theme or world. */
  clear() {
    this.kept.clear();
    this.looks.clear();
  }

  /** Return the look of a robot type. */
  look(type, world) {
    if (!this.looks.has(type)) this.looks.set(type, lookOf(world.typeIndex(type), this.palette));
    return this.looks.get(type);
  }

  /** Return the picture of a key, drawn around its center if it is not cached. */
  get(key, width, height, draw) {
    const known = this.kept.get(key);
    if (known) return known;
    if (this.kept.size >= MAX_SPRITES) this.kept.clear();
    const canvas = new OffscreenCanvas(Math.ceil(width * this.ratio), Math.ceil(height * this.ratio));
    const c = canvas.getContext('2d', { willReadFrequently: SOFTWARE });
    c.setTransform(this.ratio, 0, 0, this.ratio, canvas.width / 2, canvas.height / 2);
    draw(c);
    const sprite = { width: canvas.width / this.ratio, height: canvas.height / this.ratio, image: null };
    // A bitmap is copied several times as fast as a canvas.
    sprite.image = canvas.transferToImageBitmap();
    this.kept.set(key, sprite);
    return sprite;
  }

  /** Return the index of the next larger cached radius. */
  static size(radius) { return Math.ceil(Math.log(radius) / Math.log(STEP) - 1e-6); }

  /** Return the radius with an index. */
  static radius(size) { return STEP ** size; }

  /** Return a robot in its state. @param {number} size See `size`. @param {number} heading From 0 to `HEADINGS`. */
  robot(look, flies, state, size, heading) {
    // A number, as strings would be created for each robot and frame.
    const kind = (look.index * 2 + (flies ? 1 : 0)) * STATES.length + STATES.indexOf(state);
    const key = (kind * 128 + size) * HEADINGS + heading;
    return this.kept.get(key) ?? this.drawRobot(key, look, flies, state, Sprites.radius(size), heading);
  }

  drawRobot(key, look, flies, state, radius, heading) {
    const colors = this.palette[this.theme];
    const side = 2 * radius + 8;
    return this.get(key, side, side, (c) => {
      c.rotate((heading * 2 * Math.PI) / HEADINGS);
      if (flies && radius >= 5) drawShadow(c, radius);
      const ring = this.palette.states[state];
      if (state === 'offline') c.globalAlpha = 0.45;
      if (radius < HEAD) {
        c.scale(radius, radius);
        const calm = state === 'idle' || state === 'driving' || state === 'busy';
        drawSmall(c, look, calm ? colors.robot_outline : ring, (calm ? 0.8 : 2) / radius);
        return;
      }
      circle(c, 0, 0, radius);
      if (!flies) fill(c, faint(ring, state === 'idle' ? 0.1 : 0.2));
      const dash = state === 'waiting' ? [radius * 0.35, radius * 0.25] : undefined;
      stroke(c, ring, state === 'idle' ? 1 : Math.min(2.5, 0.7 + radius / 10), dash);
      c.scale(radius, radius);
      drawBody(c, look, flies, colors.robot_outline, Math.max(0.02, 1.1 / radius));
    });
  }

  /** Return the badge of a state, or null for none. */
  badge(state, radius) {
    const glyph = STATE_GLYPHS[state];
    if (!glyph) return null;
    const side = 2 * radius + 4;
    return this.get(`badge|${state}|${radius}`, side, side, (c) =>
      drawBadge(c, glyph, 0, 0, radius, this.palette.states[state], this.palette[this.theme].floor),
    );
  }

  /** Return a battery as a bar; *tenths* from 0 to 10. */
  battery(tenths, width) {
    const colors = this.palette[this.theme];
    return this.get(`battery|${tenths}|${width}`, width + 2, 6, (c) => {
      plate(c, -width / 2, -2.5, width, 5, 2.5);
      fill(c, mixed(colors.floor, colors.muted, 0.7));
      plate(c, -width / 2 + 1, -1.5, Math.max(2, ((width - 2) * tenths) / 10), 3, 1.5);
      fill(c, tenths <= 2 ? this.palette.dark.fault : this.palette.dark.charger);
    });
  }

  /** Return a name on a plate; a chosen robot's is inverted. */
  name(text, chosen) {
    const colors = this.palette[this.theme];
    const width = Math.ceil(this.measure.measureText(text).width) + 10;
    return this.get(`name|${text}|${chosen}`, width, NAME_HEIGHT, (c) => {
      plate(c, -width / 2 + 0.5, -NAME_HEIGHT / 2 + 0.5, width - 1, NAME_HEIGHT - 1, 4);
      fill(c, chosen ? colors.selected : faint(colors.background, 0.88));
      stroke(c, chosen ? colors.selected : colors.line, 1);
      const fillStyle = chosen ? inkOn(colors.selected) : colors.ink;
      Object.assign(c, { font: NAME_FONT, textAlign: 'center', textBaseline: 'middle', fillStyle });
      c.fillText(text, 0, 0.5);
    });
  }

  /** Return an item, as a small parcel. */
  item(size) {
    const colors = this.palette[this.theme];
    return this.get(`item|${size}`, size + 4, size + 4, (c) => {
      plate(c, -size / 2, -size / 2, size, size, size * 0.22);
      fill(c, colors.item);
      stroke(c, colors.floor, 1);
      if (size < 10) return;
      c.beginPath();
      for (const [x, y] of [[0, size / 2], [size / 2, 0]]) c.moveTo(-x, -y), c.lineTo(x, y);
      stroke(c, faint(colors.floor, 0.7), 1);
    });
  }
}

/** Draw the soft shadow of a flying robot, on all sides so that it can be turned. */
function drawShadow(c, radius) {
  const shade = c.createRadialGradient(0, 0, radius * 0.4, 0, 0, radius + 4);
  shade.addColorStop(0, 'rgb(0 0 0 / 0.3)');
  shade.addColorStop(1, 'rgb(0 0 0 / 0)');
  circle(c, 0, 0, radius + 4);
  fill(c, shade);
}

function drawsBySoftware() {
  const gl = globalThis.document?.createElement('canvas').getContext('webgl');
  if (!gl) return true;
  const info = gl.getExtension('WEBGL_debug_renderer_info');
  const renderer = String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
  gl.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(renderer);
}
