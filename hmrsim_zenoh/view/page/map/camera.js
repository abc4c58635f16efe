/**
 * The camera: zoom, pan and follow, and conversion between coordinates of world and screen.
 * In meters y points up, in pixels down. Only the camera knows this.
 */

const PADDING = 20; // css pixels of free margin after fitting
const GLIDE = 0.24; // seconds of a camera's animation
const CLOSEST = { m: 400, px: 8 }; // css pixels per unit of the world at most

export class Camera {
  /** @param {() => void} changed Called after each change. */
  constructor(changed) {
    this.changed = changed;
    this.x = this.y = 0;
    this.scale = 1; // css pixels per unit of the world
    this.flip = -1; // the direction of y on the screen: -1 if y points up
    this.width = this.height = 1;
    this.insets = { top: 0, right: 0, bottom: 0, left: 0 }; // css pixels at the edges that panels cover
    this.box = [0, 0, 1, 1];
    this.closest = CLOSEST.m;
    this.fitted = true; // whether it has not moved since it was fitted, so that it fits again when the size changes
    this.glide = null;
    this.calm = globalThis.matchMedia?.('(prefers-reduced-motion: reduce)') ?? { matches: false };
  }

  /** @param {number[]} box least x, least y, greatest x, greatest y */
  setWorld(units, box) {
    this.flip = units === 'px' ? 1 : -1;
    this.closest = CLOSEST[units];
    this.box = box;
    this.fit(false);
  }

  resize(width, height) {
    if (width === this.width && height === this.height) return;
    Object.assign(this, { width, height });
    if (this.fitted) this.fit(false);
    this.changed();
  }

  /** Show everything. */
  fit(smooth = true) {
    this.moveTo(this.fitting(), smooth);
    this.fitted = true;
  }

  /** @returns {{x: number, y: number, scale: number}} the view that shows everything */
  fitting() {
    const [x0, y0, x1, y1] = this.box;
    const { top, right, bottom, left } = this.insets;
    const padding = Math.min(PADDING, this.width * 0.05);
    const width = Math.max(40, this.width - left - right - 2 * padding);
    const height = Math.max(40, this.height - top - bottom - 2 * padding);
    const scale = Math.min(width / Math.max(x1 - x0, 1e-6), height / Math.max(y1 - y0, 1e-6), this.closest);
    return this.centered((x0 + x1) / 2, (y0 + y1) / 2, scale);
  }

  /** Return the view with a point in the center of the uncovered part. */
  centered(x, y, scale = this.scale) {
    const { top, right, bottom, left } = this.insets;
    return { x: x + (right - left) / 2 / scale, y: y + (this.flip * (bottom - top)) / 2 / scale, scale };
  }

  /** Zoom by a factor around a point of the screen. */
  zoomAt(px, py, factor, smooth = false) {
    const base = this.glide?.to ?? this;
    const scale = Math.min(this.closest, Math.max(this.fitting().scale / 8, base.scale * factor));
    const moved = 1 / base.scale - 1 / scale;
    const x = base.x + (px - this.width / 2) * moved;
    const y = base.y + (py - this.height / 2) * this.flip * moved;
    this.moveTo({ x, y, scale }, smooth);
  }

  /** Move the view by css pixels. */
  panBy(dx, dy) {
    this.moveTo({ x: this.x - dx / this.scale, y: this.y - (this.flip * dy) / this.scale, scale: this.scale }, false);
  }

  /** Return whether a point of the world is in the uncovered part. */
  shows(x, y) {
    const { top, right, bottom, left } = this.insets;
    const [px, py] = this.toScreen([x, y]);
    return px > left + PADDING && px < this.width - right - PADDING && py > top + PADDING && py < this.height - bottom - PADDING;
  }

  /** Center a point in the uncovered part. */
  centerOn(x, y, smooth = true) { this.moveTo(this.centered(x, y), smooth); }

  /** Follow a moving robot. */
  chase(x, y, seconds) {
    const share = this.calm.matches ? 1 : 1 - Math.exp(-seconds / 0.12);
    const to = this.centered(x, y);
    const [dx, dy] = [(to.x - this.x) * share, (to.y - this.y) * share];
    if (Math.hypot(dx, dy) * this.scale < 0.02) return;
    this.x += dx;
    this.y += dy;
    this.fitted = false;
    this.changed();
  }

  moveTo({ x, y, scale }, smooth) {
    this.fitted = false;
    this.glide = smooth && !this.calm.matches ? { from: { x: this.x, y: this.y, scale: this.scale }, to: { x, y, scale }, began: null } : null;
    if (!this.glide) Object.assign(this, { x, y, scale });
    this.changed();
  }

  /** Advance the animation, if there is one. */
  advance(wallMs) {
    if (!this.glide) return;
    const { from, to } = this.glide;
    this.glide.began ??= wallMs;
    const time = Math.min(1, (wallMs - this.glide.began) / 1000 / GLIDE);
    const share = 1 - (1 - time) ** 3;
    this.scale = from.scale * (to.scale / from.scale) ** share;
    // The center moves with the scale, so that the point below the pointer stays.
    const even = Math.abs(to.scale / from.scale - 1) < 1e-6;
    const moved = even ? share : (1 / from.scale - 1 / this.scale) / (1 / from.scale - 1 / to.scale);
    this.x = from.x + (to.x - from.x) * moved;
    this.y = from.y + (to.y - from.y) * moved;
    if (time === 1) Object.assign(this, to, { glide: null });
    this.changed();
  }

  /** @returns {Camera} A still copy that sees more css pixels on each side. */
  widened(margin) {
    const insets = Object.fromEntries(Object.entries(this.insets).map(([edge, covered]) => [edge, covered + margin]));
    const [width, height] = [this.width + 2 * margin, this.height + 2 * margin];
    return Object.assign(Object.create(Camera.prototype), this, { width, height, insets });
  }

  /** @returns {[number, number]} A point of the world in css pixels. */
  toScreen([x, y]) { return [this.screenX(x), this.screenY(y)]; }

  /** Return whether a point is on the screen, or at most *margin* css pixels outside. */
  sees(px, py, margin = 0) { return px > -margin && py > -margin && px < this.width + margin && py < this.height + margin; }

  screenX(x) { return this.width / 2 + (x - this.x) * this.scale; }

  screenY(y) { return this.height / 2 + this.flip * (y - this.y) * this.scale; }

  worldX(px) { return this.x + (px - this.width / 2) / this.scale; }

  worldY(py) { return this.y + (this.flip * (py - this.height / 2)) / this.scale; }
}
