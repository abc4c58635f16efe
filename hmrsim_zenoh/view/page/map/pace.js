/** How finely and how often is drawn: less so where frames come too slowly, which it learns from those that have come. */

const SHARPEST = 2; // device pixels a css pixel
const SLOW = 45; // ms from frame to frame from which less sharp ones are drawn
const DEAR = 12; // ms of script a frame from which every second one is left out
const LEARNED = 40; // frames from which it learns

export class Pace {
  constructor() {
    /** Device pixels a css pixel at most. */
    this.sharpest = SHARPEST;
    /** Whether only every second frame is drawn. */
    this.halved = false;
    this.skipped = false;
    this.forget();
  }

  /** @returns {boolean} whether to leave this frame out */
  skips() {
    this.skipped = this.halved && !this.skipped;
    return this.skipped;
  }

  /** Nothing moves: what comes next is not late. */
  rest() {
    this.before = NaN;
  }

  /** A frame has been drawn. @param {number} wallMs when @param {number} took ms of script @param {number} ratio */
  add(wallMs, took, ratio) {
    const gap = wallMs - this.before;
    this.before = wallMs;
    // A page that was hidden for a second is not slow.
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
