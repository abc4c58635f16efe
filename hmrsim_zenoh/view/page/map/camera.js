/**
 * The camera: zoom, pan and follow, and conversion between coordinates of world and screen.
 * In meters y points up, in pixels down. Only the camera knows this.
 */

const PADDING = 20; // css pixels of free margin after fitting
const GLIDE = 0.24; // seconds of a camera's animation
const CLOSEST = 400; // css pixels per meter at most; for worlds in pixels see setWorld

export class Camera {
  /** @param {() => void} changed Called after each change. */
  constructor(changed) {
    this.changed = changed;
    this.x = 0;
    this.y = 0;
    this.scale = 1; // css pixels per unit of the world
    this.flip = -1; // the direction of y on the screen: -1 if y points up
    this.width = 1;
    this.height = 1;
    this.insets = { top: 0, right: 0, bottom: 0, left: 0 }; // css pixels at the edges that panels cover
    this.box = [0, 0, 1, 1];
    this.fitted = true; // whether it has not moved since it was fitted, so that it fits again when the size changes
    this.glide = null;
    this.calm = globalThis.matchMedia?.('(prefers-reduced-motion: reduce)') ?? { matches: false };
  }

  /** @param {number[]} box least x, least y, greatest x, greatest y */
  setWorld(units, box) {
    this.flip = units === 'px' ? 1 : -1;
    this.closest = units === 'px' ? 8 : CLOSEST;
    this.box = box;
    this.fit(false);
  }

  resize(width, height) {
    if (width === this.width && height === this.height) return;
    this.width = width;
    this.height = height;
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
    const scale = Math.min(width / Math.max(x1 - x0, 1e-6), height / Math.max(y1 - y0, 1e-6), this.closest ?? CLOSEST);
    return { x: (x0 + x1) / 2 + this.shiftX(scale), y: (y0 + y1) / 2 + this.shiftY(scale), scale };
  }

  /** The distance of the camera from the center of the uncovered part, in the world's unit. */
  shiftX(scale) { return (this.insets.right - this.insets.left) / 2 / scale; }

  shiftY(scale) { return (this.flip * (this.insets.bottom - this.insets.top)) / 2 / scale; }

  /** Zoom by a factor around a point of the screen. */
  zoomAt(px, py, factor, smooth = false) {
    const base = this.glide?.to ?? this;
    const least = this.fitting().scale / 8;
    const scale = Math.min(this.closest ?? CLOSEST, Math.max(least, base.scale * factor));
    const dx = px - this.width / 2;
    const dy = (py - this.height / 2) * this.flip;
    const x = base.x + dx / base.scale - dx / scale;
    const y = base.y + dy / base.scale - dy / scale;
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
  centerOn(x, y, smooth = true) {
    const { scale } = this;
    this.moveTo({ x: x + this.shiftX(scale), y: y + this.shiftY(scale), scale }, smooth);
  }

  /** Follow a moving robot. */
  chase(x, y, seconds) {
    const share = this.calm.matches ? 1 : 1 - Math.exp(-seconds / 0.12);
    const dx = (x + this.shiftX(this.scale) - this.x) * share;
    const dy = (y + this.shiftY(this.scale) - this.y) * share;
    if (Math.hypot(dx, dy) * this.scale < 0.02) return;
    this.x += dx;
    this.y += dy;
    this.fitted = false;
    this.changed();
  }

  moveTo(to, smooth) {
    this.fitted = false;
    if (smooth && !this.calm.matches) {
      this.glide = { from: { x: this.x, y: this.y, scale: this.scale }, to, began: null };
    } else {
      this.glide = null;
      Object.assign(this, { x: to.x, y: to.y, scale: to.scale });
    }
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
    if (time === 1) {
      this.glide = null;
      Object.assign(this, { x: to.x, y: to.y, scale: to.scale });
    }
    this.changed();
  }

  /** @returns {Camera} A still copy that sees more css pixels on each side. */
  widened(margin) {
    const { width, height } = this;
    const insets = Object.fromEntries(Object.entries(this.insets).map(([edge, covered]) => [edge, covered + margin]));
    return Object.assign(Object.create(Camera.prototype), this, {
      width: width + 2 * margin, height: height + 2 * margin, insets,
    });
  }

  /** @returns {[number, number]} A point of the world in css pixels. */
  toScreen([x, y]) { return [this.screenX(x), this.screenY(y)]; }

  /** Return whether a point is on the screen, or at most *margin* css pixels outside. */
  sees(px, py, margin = 0) {
    return px > -margin && py > -margin && px < this.width + margin && py < this.height + margin;
  }

  screenX(x) { return this.width / 2 + (x - this.x) * this.scale; }

  screenY(y) { return this.height / 2 + this.flip * (y - this.y) * this.scale; }

  worldX(px) { return this.x + (px - this.width / 2) / this.scale; }

  worldY(py) { return this.y + (this.flip * (py - this.height / 2)) / this.scale; }
}
