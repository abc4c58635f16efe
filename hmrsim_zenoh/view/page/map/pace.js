/** How many frames the browser can take. */

const SHARPEST = 2; // device pixels per css pixel
const SLOW = 45; // ms between frames from which the resolution is reduced
const DEAR = 12; // ms of script per frame from which every other frame is skipped
const LEARNED = 40; // frames to average
const KEPT = 60;

/** Adapts resolution and frame rate to the browser's speed, and measures frames for benchmarks. */
export class Pace {
  constructor() {
    this.sharpest = SHARPEST; // the largest number of device pixels per css pixel
    this.halved = false; // whether only every other frame is drawn
    this.skipped = false;
    this.frames = 0; // the number of drawn frames
    this.drawn = 0; // robots in sight
    this._last = []; // the milliseconds of script of the latest frames
    this.forget();
  }

  /** Mean milliseconds of script per frame, over the last 60. */
  get scriptMs() { return this._last.reduce((sum, took) => sum + took, 0) / (this._last.length || 1); }

  /** Return whether to skip this frame. */
  skips() {
    this.skipped = this.halved && !this.skipped;
    return this.skipped;
  }

  /** Note that nothing moves, so that the next frame is not late. */
  rest() { this.before = NaN; }

  /** Note a drawn frame. @param {number} took ms of script */
  add(wallMs, took, ratio, drawn) {
    this._last[this.frames % KEPT] = took;
    this.frames += 1;
    this.drawn = drawn;
    const gap = wallMs - this.before;
    this.before = wallMs;
    // A hidden page is not slow.
    if (!(gap < 1000)) return;
    this.gaps += gap;
    this.took += took;
    this.count += 1;
    if (this.count < LEARNED) return;
    if (this.gaps / this.count > SLOW && ratio > 1) this.sharpest = ratio > 1.5 ? 1.5 : 1;
    this.halved = this.took / this.count > DEAR;
    this.forget();
  }

  forget() {
    this.before = NaN;
    this.gaps = this.took = this.count = 0;
  }
}
