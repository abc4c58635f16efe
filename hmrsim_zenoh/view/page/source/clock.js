// Simulated time as it passes here: smooth between what is received, and a little behind it.
//
// What is received is late, by a different while each time. Where time moves at a known rate, the least late of the last
// seconds says how simulated and wall time lie to each other; we go with that, less a margin that lets what happens
// arrive before it is shown. Small corrections are made by going a little faster or slower, never back.
// Where time stands or moves in bursts (lockstep, as fast as possible, steps while paused), we glide to what was received
// last, back as well if we were ahead of it.

const MARGIN = 0.1; // wall seconds behind what is received
const WINDOW = 2000; // ms in which the least late counts
const GLIDE = 120; // ms from one burst to the next: frames come each 50 ms
const MAX_AHEAD = 0.5; // wall seconds beyond what was received last; then the simulator is gone
const MIN_STEP = 0.25; // simulated seconds, likewise: the clock ticks each 0.1 s
const STANDS = 1000; // ms without any later time, from which on time is taken to stand
const EASE = 0.5; // wall seconds in which most of an error is made good
const SLEW = 0.2; // share by which we go faster or slower at most
const SETTLED = 1e-3; // seconds of error that are not seen
const STALE = 500; // ms in which what was sent before time went back may still come
const JUMP = 1.0; // wall seconds of error that are no small correction

export class SimClock {
  /** Simulated seconds a wall second; 0 where time moves in bursts. */
  factor = 0;
  paused = false;
  /** The last simulated time that was received; null before the first. @type {number | null} */
  received = null;

  #shown = 0; // what `now` said at #at
  #at = 0;
  /** [wall, simulated - wall * factor] of what was received, greatest first. @type {[number, number][]} */
  #offsets = [];
  /** Since when nothing but earlier times are received. @type {number | null} */ #backSince = null;
  #receivedAt = 0; // when a later time was received for the last time
  #from = 0; // of a glide
  #began = 0;

  /** Return simulated seconds. */
  now(wallMs = performance.now()) {
    if (this.received === null) return 0;
    const elapsed = wallMs - this.#at;
    if (elapsed > 0) {
      this.#shown = this.#flows ? this.#flow(wallMs, elapsed / 1000) : this.#glide(wallMs);
      this.#at = wallMs;
    }
    return this.#shown;
  }

  /** Take a simulated time that was just told. */
  receive(simSeconds, wallMs = performance.now()) {
    if (this.received === null) {
      this.reset(simSeconds, wallMs);
      return;
    }
    if (simSeconds < this.received) {
      // What comes together need not be in order, but for so long it is time that went back.
      this.#backSince ??= wallMs;
      if (wallMs - this.#backSince > STALE) this.reset(simSeconds, wallMs);
    } else {
      this.#backSince = null;
      if (simSeconds > this.received) {
        this.#from = this.now(wallMs);
        this.#began = this.#receivedAt = wallMs;
        this.received = simSeconds;
      }
    }
    if (!this.#flows) return;
    const offset = simSeconds - (wallMs / 1000) * this.factor;
    while (this.#offsets.length && this.#offsets[this.#offsets.length - 1][1] <= offset) this.#offsets.pop();
    this.#offsets.push([wallMs, offset]);
    while (this.#offsets[0][0] < wallMs - WINDOW) this.#offsets.shift();
  }

  /**
   * Say how fast time moves.
   * @param {number} factor simulated seconds a wall second; 0 where it moves in bursts, as in lockstep
   */
  setRate(factor, paused, wallMs = performance.now()) {
    if (factor === this.factor && paused === this.paused) return;
    this.now(wallMs);
    this.factor = factor;
    this.paused = paused;
    this.#offsets = [];
    this.#from = this.#shown;
    this.#began = this.#receivedAt = wallMs;
  }

  /** Go there at once, forward or back, as after a reset of the simulation. */
  reset(simSeconds, wallMs = performance.now()) {
    this.received = this.#shown = this.#from = simSeconds;
    this.#at = this.#began = this.#receivedAt = wallMs;
    this.#offsets = [];
    this.#backSince = null;
  }

  get #flows() {
    return this.factor > 0 && !this.paused;
  }

  /** Go on at the known rate, a little faster or slower where that is wrong. */
  #flow(wallMs, elapsed) {
    if (wallMs - this.#receivedAt > STANDS * Math.max(1, 1 / this.factor)) return this.#settle(elapsed);
    const step = elapsed * this.factor;
    const most = this.received + Math.max(MAX_AHEAD * this.factor, MIN_STEP);
    if (!this.#offsets.length) return Math.max(this.#shown, Math.min(this.#shown + step, most));
    const aim = (wallMs / 1000 - MARGIN) * this.factor + this.#offsets[0][1];
    const error = aim - (this.#shown + step);
    if (error > JUMP * this.factor) return Math.min(aim, most);
    const correction = Math.max(-SLEW * step, Math.min(SLEW * step, (error * elapsed) / EASE));
    return Math.max(this.#shown, Math.min(this.#shown + step + correction, most));
  }

  /** Go to what was received last. */
  #glide(wallMs) {
    const share = Math.min(1, (wallMs - this.#began) / GLIDE);
    return share < 1 ? this.#from + (this.received - this.#from) * share : this.received;
  }

  /** Go back to what was received last: nothing more comes. */
  #settle(elapsed) {
    this.#offsets = [];
    const error = this.received - this.#shown;
    return Math.abs(error) < SETTLED ? this.received : this.#shown + error * Math.min(1, (8 * elapsed) / EASE);
  }
}
