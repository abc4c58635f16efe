/** How long frames take, for benchmarks. */

const KEPT = 60;

export class Stats {
  constructor() {
    /** Frames that were drawn; those in which nothing had changed don't count. */
    this.frames = 0;
    /** Robots in sight. */
    this.drawn = 0;
    /** Mean milliseconds of script a frame, of the last 60 that were drawn. */
    this.scriptMs = 0;
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
