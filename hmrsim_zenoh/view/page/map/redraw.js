/** When to draw: what has changed in the model, and how many frames the browser can take. */

const SHARPEST = 2; // device pixels per css pixel
const SLOW = 45; // ms between frames from which the resolution is reduced
const DEAR = 12; // ms of script per frame from which every other frame is skipped
const LEARNED = 40; // frames to average

/** Adapts resolution and frame rate to the browser's speed. */
export class Pace {
  constructor() {
    this.sharpest = SHARPEST; // the largest number of device pixels per css pixel
    this.halved = false; // whether only every other frame is drawn
    this.skipped = false;
    this.forget();
  }

  /** Return whether to skip this frame. */
  skips() {
    this.skipped = this.halved && !this.skipped;
    return this.skipped;
  }

  /** Note that nothing moves, so that the next frame is not late. */
  rest() { this.before = NaN; }

  /** Note a drawn frame. @param {number} took ms of script */
  add(wallMs, took, ratio) {
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

const KEPT = 60;

/** The duration of frames, for benchmarks. */
export class Stats {
  constructor() {
    this.frames = 0; // the number of drawn frames
    this.drawn = 0; // robots in sight
    this.scriptMs = 0; // mean milliseconds of script per frame, over the last 60
    this._last = new Float64Array(KEPT);
  }

  add(milliseconds, drawn) {
    this._last[this.frames % KEPT] = milliseconds;
    this.frames += 1;
    this.drawn = drawn;
    const count = Math.min(KEPT, this.frames);
    let sum = 0;
    for (let i = 0; i < count; i++) sum += this._last[i];
    this.scriptMs = sum / count;
  }
}

/** Requests redraws for changes of a model. */
export class Watch {
  constructor(model, view) {
    this.model = model;
    this.view = view;
    this.fixtures = []; // the fixtures as drawn; their values are replaced and never changed
    this.closed = '';
    model.addEventListener('world', () => view.worldChanged());
    for (const kind of ['scene', 'robots', 'faults']) model.addEventListener(kind, () => this.look());
  }

  look() {
    this.view.changed(false);
    if (this.fixturesChanged() || this.closuresChanged()) this.view.changed(true);
  }

  fixturesChanged() {
    let count = 0;
    let changed = false;
    for (const fixtures of [this.model.docks, this.model.doors, this.model.lifts]) {
      for (const fixture of fixtures.values()) {
        if (this.fixtures[count] !== fixture) {
          this.fixtures[count] = fixture;
          changed = true;
        }
        count += 1;
      }
    }
    this.fixtures.length = count;
    return changed;
  }

  closuresChanged() {
    const closed = this.model.closedLanes.size ? [...this.model.closedLanes.keys()].join() : '';
    const changed = closed !== this.closed;
    this.closed = closed;
    return changed;
  }
}
