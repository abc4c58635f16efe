// The simulated time that the page shows: smooth between received times, and slightly behind them.
//
// Messages arrive with varying delay. If time advances at a known rate, the least delayed message of the last seconds
// gives the offset between simulated and wall time. The clock follows it, minus a margin within which events arrive
// before they are shown. It makes small corrections by running slightly faster or slower, never backwards.
// If time stands or advances in bursts (lockstep, as fast as possible, steps while paused), the clock glides to the latest
// received time, even backwards.

const MARGIN = 0.1; // wall seconds behind received times
const WINDOW = 2000; // ms from which the least delayed message counts
const GLIDE = 120; // ms from one burst to the next; frames arrive every 50 ms
const MAX_AHEAD = 0.5; // wall seconds beyond the latest received time, after which the simulator counts as gone
const MIN_STEP = 0.25; // the same in simulated seconds at least, as the clock ticks every 0.1 s
const STANDS = 1000; // ms without a later time after which time counts as standing
const EASE = 0.5; // wall seconds in which most of an error is corrected
const SLEW = 0.2; // largest relative change of speed for corrections
const SETTLED = 1e-3; // seconds of error that are invisible
const STALE = 500; // ms in which messages from before a reset may still arrive
const JUMP = 1.0; // wall seconds of error from which the clock jumps

export class SimClock {
  factor = 0; // simulated seconds per wall second; 0 if time advances in bursts
  paused = false;
  received = null; // the latest received simulated time; null before the first

  /** @type {number | null} */ #held = null;
  #shown = 0; // the result of `live` at #at
  #at = 0;
  #offsets = []; // [wall, simulated - wall * factor] of received times, greatest first
  /** The time since which only earlier times are received. @type {number | null} */ #backSince = null;
  #receivedAt = 0; // when the latest time was received
  #from = 0; // the start of a glide
  #began = 0;

  /** Return the simulated seconds that the page shows. */
  now(wallMs = performance.now()) { return this.#held ?? this.live(wallMs); }

  /** Show a past time; null for the present. */
  hold(seconds) { this.#held = seconds; }

  /** Return the simulated seconds of the present. */
  live(wallMs = performance.now()) {
    if (this.received === null) return 0;
    const elapsed = wallMs - this.#at;
    if (elapsed > 0) {
      this.#shown = this.#flows ? this.#flow(wallMs, elapsed / 1000) : this.#glide(wallMs);
      this.#at = wallMs;
    }
    return this.#shown;
  }

  /** Process a received simulated time. */
  receive(simSeconds, wallMs = performance.now()) {
    if (this.received === null) return this.reset(simSeconds, wallMs);
    if (simSeconds < this.received) {
      // Messages may be slightly out of order. After this long, time has really gone back.
      this.#backSince ??= wallMs;
      if (wallMs - this.#backSince > STALE) this.reset(simSeconds, wallMs);
    } else {
      this.#backSince = null;
      if (simSeconds > this.received) {
        this.#from = this.live(wallMs);
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
   * Set the rate of time.
   * @param {number} factor Simulated seconds per wall second; 0 if time advances in bursts, as in lockstep
   */
  setRate(factor, paused, wallMs = performance.now()) {
    if (factor === this.factor && paused === this.paused) return;
    this.live(wallMs);
    this.factor = factor;
    this.paused = paused;
    this.#offsets = [];
    this.#from = this.#shown;
    this.#began = this.#receivedAt = wallMs;
  }

  /** Jump to a time, forward or back, as after a reset of the simulation. */
  reset(simSeconds, wallMs = performance.now()) {
    this.received = this.#shown = this.#from = simSeconds;
    this.#at = this.#began = this.#receivedAt = wallMs;
    this.#offsets = [];
    this.#backSince = null;
  }

  get #flows() { return this.factor > 0 && !this.paused; }

  /** Advance at the known rate, slightly faster or slower to correct an error. */
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

  /** Glide to the latest received time. */
  #glide(wallMs) {
    const share = Math.min(1, (wallMs - this.#began) / GLIDE);
    return share < 1 ? this.#from + (this.received - this.#from) * share : this.received;
  }

  /** Settle at the latest received time, as no more arrive. */
  #settle(elapsed) {
    this.#offsets = [];
    const error = this.received - this.#shown;
    return Math.abs(error) < SETTLED ? this.received : this.#shown + error * Math.min(1, (8 * elapsed) / EASE);
  }
}
