/** The map: one canvas for static and one for moving objects, and pointer interaction. */

import { el } from '../panels/dom.js';
import { Camera } from './camera.js';
import { drawCauses, drawDeadlocks, drawFaults } from './fixtures.js';
import { Gestures } from './gestures.js';
import { Names } from './names.js';
import { Tooltip, pickAt, tooltipOf } from './picking.js';
import { Pace } from './pace.js';
import { Poses, anyRobotMoves, drawItems, drawRobots, drawSensors } from './robot_layer.js';
import { SOFTWARE, Sprites } from './sprites.js';
import { MARGIN, StaticLayer, drawScaleBar, measuresOf } from './static_layer.js';
import { drawAhead, drawDriven, drawPreview } from './trails.js';

const RESTING = 200; // ms between two checks of what is below a resting pointer
const LAYERS = { lanes: true, names: true, routes: true, driven: true, sensors: true, walls: true };

/**
 * The map; its layers draw it as a `frame`: camera, model, world, `measures`, the `colors` of the theme, the whole `palette`,
 * the shown `layers`, `ratio` device pixels per css pixel, and what is selected, followed, hovered and previewed.
 *
 * Dispatches 'pick' (a click or tap), 'menu' (a right click or long press) and 'hover', whose `detail` is a `Pick` with
 * `px` and `py` (null when the pointer has left); 'follow' when a drag has ended following.
 */
export class MapView extends EventTarget {
  constructor(element, model, clock, palette) {
    super();
    Object.assign(this, { element, model, clock, palette });
    this._still = el('canvas', { class: 'map-still' });
    this._moving = el('canvas', { class: 'map-moving', role: 'img', 'aria-label': 'map with robots' });
    element.append(this._still, this._moving);
    this._c = this._moving.getContext('2d', { willReadFrequently: SOFTWARE });
    this._sprites = new Sprites(palette);
    this._stillLayer = new StaticLayer(this._still);
    this._names = new Names(this._sprites, this._stillLayer.signs);
    this._poses = new Poses();
    this._tooltip = new Tooltip(element);
    this._pointer = [null, null];
    this._pointed = 0;
    this._below = '';
    this._pace = new Pace();
    this._lastTime = NaN;
    this._lastWall = 0;
    this._stillDirty = this._movingDirty = true;
    this._cameraMoved = false;
    this.camera = new Camera(() => (this._cameraMoved = true));
    this.layers = new Proxy({ ...LAYERS }, { set: (layers, key, on) => this._set(layers, key, on, true) });
    const chosen = { follow: null, selected: null, goalPreview: null };
    for (const key of Object.keys(chosen)) {
      Object.defineProperty(this, key, { get: () => chosen[key], set: (value) => this._set(chosen, key, value ?? null, false) });
    }
    this.ratio = 1;
    this.world = this.hovered = null;
    this.theme = 'light';
    new Gestures(element, this._handler());
    model.addEventListener('world', () => this.worldChanged());
    for (const kind of ['fixtures', 'scene', 'robots', 'faults']) model.addEventListener(kind, () => this.changed(kind === 'fixtures'));
    new ResizeObserver(() => (this._stillDirty = true)).observe(element);
    if (model.world.known) this.worldChanged();
  }

  /** The frames so far, for benchmarks. */
  get stats() { return this._pace; }

  /** @param {'dark'|'light'} theme */
  set theme(theme) {
    this.colors = this.palette[theme];
    this._sprites.theme = theme;
    this._sprites.clear();
    this._stillDirty = true;
  }

  /** @returns {[number, number]} Css pixels within the element. */
  toScreen(x, y) { return this.camera.toScreen([x, y]); }

  /** @returns {import('./picking.js').Pick} The object at a point of the screen. */
  pick(px, py) { return pickAt(this, this._poses, px, py); }

  /** @returns {{name: string, box: number[], line: boolean}[]} The names on the map: left, top, width and height in css pixels. */
  get labels() {
    const { signs } = this._stillLayer;
    const still = signs.placed.map(({ name, box: [left, top, ...size], line }) => ({ name, line, box: [left + signs.left, top + signs.top, ...size] }));
    return [...still, ...this._names.placed.map(({ name, left, top, sprite, to }) => ({ name, line: to !== null, box: [left, top, sprite.width, sprite.height] }))];
  }

  /** Draw all changes since the last call; call this in each animation frame. */
  draw(wallMs = performance.now()) {
    const began = performance.now();
    const time = this.clock.now(wallMs);
    this._resize();
    this.camera.advance(wallMs);
    this._chase(time, wallMs);
    if (wallMs - this._pointed >= RESTING) this._hover(time, wallMs);
    if (this._stillLayer.signs.stale(this, wallMs)) this._stillDirty = true;
    const moves = time !== this._lastTime && anyRobotMoves(this.model, this._lastTime, time);
    const dirty = this._stillDirty || this._movingDirty || this._cameraMoved;
    if (!dirty && !moves) {
      this._pace.rest();
      return;
    }
    if (!this._stillDirty && this._pace.skips()) return;
    if (this._stillDirty || (this._cameraMoved && !this._stillLayer.shift(this))) this._stillLayer.draw(this);
    this._drawMoving(time, wallMs);
    this._stillDirty = this._movingDirty = this._cameraMoved = false;
    this._lastTime = time;
    this._pace.add(wallMs, performance.now() - began, this.ratio, this._poses.count);
  }

  /** Follow a change of the world. */
  worldChanged() {
    const before = this.measures;
    this.world = this.model.world;
    this.measures = measuresOf(this.world);
    this._sprites.clear();
    // If the world is the same, as after a restart, the camera stays.
    if (!before || this.camera.fitted || String(before.box) !== String(this.measures.box)) {
      this.camera.setWorld(this.world.units, this.measures.box);
    }
    this._stillDirty = true;
  }

  /** Request a redraw. @param {boolean} still Whether a static object has changed. */
  changed(still) {
    if (still) this._stillDirty = true;
    this._movingDirty = true;
  }

  /** Set a value, and request a redraw if it differs. */
  _set(target, key, value, still) {
    if (target[key] !== value) this.changed(still);
    target[key] = value;
    return true;
  }

  _resize() {
    const [width, height] = [this.element.clientWidth || 1, this.element.clientHeight || 1];
    const ratio = Math.min(this._pace.sharpest, globalThis.devicePixelRatio || 1);
    this.camera.resize(width, height);
    const [w, h] = [Math.round(width * ratio), Math.round(height * ratio)];
    if (this._moving.width === w && this._moving.height === h && ratio === this.ratio) return;
    Object.assign(this._moving, { width: w, height: h });
    const [wide, high] = [width + 2 * MARGIN, height + 2 * MARGIN];
    Object.assign(this._still, { width: Math.round(wide * ratio), height: Math.round(high * ratio) });
    Object.assign(this._still.style, { width: `${wide}px`, height: `${high}px` });
    this.ratio = this._sprites.ratio = ratio;
    this._sprites.clear();
    this._stillDirty = true;
  }

  _chase(time, wallMs) {
    const robot = this.follow === null ? undefined : this.model.robots.get(this.follow);
    if (robot) {
      const [x, y] = robot.poseAt(time);
      this.camera.chase(x, y, Math.min(0.1, Math.max(0, wallMs - this._lastWall) / 1000));
    }
    this._lastWall = wallMs;
  }

  _drawMoving(time, wallMs) {
    const { _c: c, _poses: poses, _sprites: sprites, layers, ratio } = this;
    c.setTransform(1, 0, 0, 1, 0, 0);
    c.clearRect(0, 0, this._moving.width, this._moving.height);
    if (!this.world) return;
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    poses.look(this, time);
    const where = (name) => poses.where(name);
    if (layers.sensors) drawSensors(c, this, poses);
    if (layers.driven) drawDriven(c, this, poses);
    if (layers.routes) drawAhead(c, this, poses);
    drawItems(c, this, sprites);
    drawCauses(c, this, poses, where);
    drawDeadlocks(c, this, where);
    drawRobots(c, this, sprites, poses, time);
    drawFaults(c, this, where);
    this._names.draw(c, this, poses, wallMs);
    drawScaleBar(c, this);
    if (this.goalPreview) drawPreview(c, this, where(this.selected));
  }

  _hover(time, wallMs) {
    const [px, py] = this._pointer;
    const rests = this._pointed > 0;
    this._pointed = wallMs;
    if (rests && px === null) return;
    const pick = px === null ? null : this.pick(px, py);
    const robot = pick?.kind === 'robot' ? pick.name : null;
    if (robot !== this.hovered) this._movingDirty = true;
    this.hovered = robot;
    this.element.style.cursor = pick && pick.kind !== 'floor' && pick.kind !== 'lane' ? 'pointer' : '';
    this._tooltip.show(pick && this.world ? tooltipOf(pick, this, time) : '', px, py, this.camera.width);
    const point = String(pick?.point);
    if (!rests || point !== this._below) this._tell('hover', pick, px, py);
    this._below = point;
  }

  _tell(kind, pick, px, py) { this.dispatchEvent(new CustomEvent(kind, { detail: pick && { ...pick, px, py } })); }

  _handler() {
    return {
      pan: (dx, dy) => {
        if (this.follow !== null) {
          this.follow = null;
          this.dispatchEvent(new CustomEvent('follow', { detail: null }));
        }
        this.camera.panBy(dx, dy);
      },
      zoom: (px, py, factor, smooth) => this.camera.zoomAt(px, py, factor, smooth),
      click: (px, py) => this._tell('pick', this.pick(px, py), px, py),
      menu: (px, py) => this._tell('menu', this.pick(px, py), px, py),
      hover: (px, py) => {
        this._pointer = [px, py];
        this._pointed = 0;
      },
      zoomsOnDouble: (px, py) => ['floor', 'lane'].includes(this.pick(px, py).kind),
    };
  }
}
