/** Pictures that are drawn once and copied often: bodies, badges, batteries and names. */

import { STATE_GLYPHS, drawBadge, drawBody, drawSmall, faint, inkOn, mixed } from './shapes.js';
import { STATES } from '../model/robot.js';

const MAX_SPRITES = 2000; // pictures kept
export const HEADINGS = 64; // in which small robots are kept: to turn a picture is dear, to copy it is not
const STEP = 1.08; // from one size that is kept to the next
export const NAME_FONT = '500 11px system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif';
const NAME_HEIGHT = 16;
const HEAD = 5.5; // css pixels of radius below which a robot is an arrow's head

/** @typedef {{image: ImageBitmap, width: number, height: number}} Sprite in css pixels */

export class Sprites {
  constructor(palette) {
    this.palette = palette;
    this.theme = 'light';
    this.ratio = 1;
    this.kept = new Map();
    this.measure = new OffscreenCanvas(1, 1).getContext('2d');
    this.measure.font = NAME_FONT;
  }

  /** Forget all, as after a change of theme. */
  clear() {
    this.kept.clear();
  }

  /** @returns {Sprite} the picture of this key, drawn about its middle if it is not there yet */
  get(key, width, height, draw) {
    const known = this.kept.get(key);
    if (known) return known;
    if (this.kept.size >= MAX_SPRITES) this.kept.clear();
    const canvas = new OffscreenCanvas(Math.ceil(width * this.ratio), Math.ceil(height * this.ratio));
    const c = canvas.getContext('2d');
    c.setTransform(this.ratio, 0, 0, this.ratio, canvas.width / 2, canvas.height / 2);
    draw(c);
    const sprite = { width: canvas.width / this.ratio, height: canvas.height / this.ratio, image: null };
    // A bitmap is copied several times as fast as a canvas is.
    sprite.image = canvas.transferToImageBitmap();
    this.kept.set(key, sprite);
    return sprite;
  }

  /** Round a radius up to the index of one that is kept. */
  static size(radius) {
    return Math.ceil(Math.log(radius) / Math.log(STEP) - 1e-6);
  }

  /** The radius with an index. */
  static radius(size) {
    return STEP ** size;
  }

  /** A robot in its state. @param {number} size as of `size` @param {number} heading from 0 to `HEADINGS`, clockwise */
  robot(look, flies, state, size, heading) {
    // A number, because a string is made anew for each robot and frame.
    const kind = (look.index * 2 + (flies ? 1 : 0)) * STATES.length + STATES.indexOf(state);
    const key = (kind * 128 + size) * HEADINGS + heading;
    return this.kept.get(key) ?? this.drawRobot(key, look, flies, state, Sprites.radius(size), heading);
  }

  drawRobot(key, look, flies, state, radius, heading) {
    const colours = this.palette[this.theme];
    const side = 2 * radius + 8;
    return this.get(key, side, side, (c) => {
      c.rotate((heading * 2 * Math.PI) / HEADINGS);
      if (flies && radius >= 5) drawShadow(c, radius);
      const ring = this.palette.states[state];
      if (state === 'offline') c.globalAlpha = 0.45;
      if (radius < HEAD) {
        c.scale(radius, radius);
        const calm = state === 'idle' || state === 'driving' || state === 'busy';
        drawSmall(c, look, calm ? colours.robot_outline : ring, (calm ? 0.8 : 2) / radius);
        return;
      }
      c.beginPath();
      c.arc(0, 0, radius, 0, 2 * Math.PI);
      c.fillStyle = faint(ring, state === 'idle' ? 0.1 : 0.2);
      if (!flies) c.fill();
      c.lineWidth = state === 'idle' ? 1 : Math.min(2.5, 0.7 + radius / 10);
      c.strokeStyle = ring;
      if (state === 'waiting') c.setLineDash([radius * 0.35, radius * 0.25]);
      c.stroke();
      c.setLineDash([]);
      c.scale(radius, radius);
      drawBody(c, look, flies, colours.robot_outline, Math.max(0.02, 1.1 / radius));
    });
  }

  /** The mark of a state, or null for one that needs none. */
  badge(state, radius) {
    const glyph = STATE_GLYPHS[state];
    if (!glyph) return null;
    const side = 2 * radius + 4;
    return this.get(`badge|${state}|${radius}`, side, side, (c) =>
      drawBadge(c, glyph, 0, 0, radius, this.palette.states[state], this.palette[this.theme].floor),
    );
  }

  /** A battery as a bar; *tenths* from 0 to 10. */
  battery(tenths, width) {
    const colours = this.palette[this.theme];
    return this.get(`battery|${tenths}|${width}`, width + 2, 6, (c) => {
      c.beginPath();
      c.roundRect(-width / 2, -2.5, width, 5, 2.5);
      c.fillStyle = mixed(colours.floor, colours.muted, 0.7);
      c.fill();
      c.beginPath();
      c.roundRect(-width / 2 + 1, -1.5, Math.max(2, ((width - 2) * tenths) / 10), 3, 1.5);
      c.fillStyle = tenths <= 2 ? this.palette.dark.fault : this.palette.dark.charger;
      c.fill();
    });
  }

  /** A name on a plate; a chosen robot's is inverted. */
  name(text, chosen) {
    const colours = this.palette[this.theme];
    const width = Math.ceil(this.measure.measureText(text).width) + 10;
    return this.get(`name|${text}|${chosen}`, width, NAME_HEIGHT, (c) => {
      c.beginPath();
      c.roundRect(-width / 2 + 0.5, -NAME_HEIGHT / 2 + 0.5, width - 1, NAME_HEIGHT - 1, 4);
      c.fillStyle = chosen ? colours.selected : faint(colours.background, 0.88);
      c.fill();
      c.strokeStyle = chosen ? colours.selected : colours.line;
      c.stroke();
      c.font = NAME_FONT;
      c.textAlign = 'center';
      c.textBaseline = 'middle';
      c.fillStyle = chosen ? inkOn(colours.selected) : colours.ink;
      c.fillText(text, 0, 0.5);
    });
  }

  /** An item, as a small parcel. */
  item(size) {
    const colours = this.palette[this.theme];
    return this.get(`item|${size}`, size + 4, size + 4, (c) => {
      c.beginPath();
      c.roundRect(-size / 2, -size / 2, size, size, size * 0.22);
      c.fillStyle = colours.item;
      c.fill();
      c.lineWidth = 1;
      c.strokeStyle = colours.floor;
      c.stroke();
      if (size < 10) return;
      c.beginPath();
      c.moveTo(0, -size / 2);
      c.lineTo(0, size / 2);
      c.moveTo(-size / 2, 0);
      c.lineTo(size / 2, 0);
      c.strokeStyle = faint(colours.floor, 0.7);
      c.stroke();
    });
  }
}

/** What is in the air has a soft shadow, which is all around it, so that it may be turned. */
function drawShadow(c, radius) {
  const shade = c.createRadialGradient(0, 0, radius * 0.4, 0, 0, radius + 4);
  shade.addColorStop(0, 'rgb(0 0 0 / 0.3)');
  shade.addColorStop(1, 'rgb(0 0 0 / 0)');
  c.beginPath();
  c.arc(0, 0, radius + 4, 0, 2 * Math.PI);
  c.fillStyle = shade;
  c.fill();
}
