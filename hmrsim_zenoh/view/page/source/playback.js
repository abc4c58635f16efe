/** Samples that are played forwards and backwards, such as those of a recording. */

import { partOf } from '../model/changes.js';
import { ABORTED } from '../model/goals.js';
import { isValid, secondsOf } from '../model/messages.js';
import { Model } from '../model/model.js';
import { describe } from '../model/texts.js';
import { World } from '../model/world.js';

const MAX_KEYFRAMES = 40;
const MIN_BETWEEN = 2000;
const SLICE_MS = 8;
const JITTER = 1e-3;

/**
 * @typedef {'aborted'|'fault'|'deadlock'|'reset'} MarkKind
 * @typedef {{t: number, kind: MarkKind, text: string}} Mark
 * @typedef {{reset: (seconds: number, wallMs: number) => void,
 *   setRate: (factor: number, paused: boolean) => void}} Clock A `SimClock`.
 */

/**
 * Samples that are played into a model. Its times are simulated seconds that continue after a reset.
 *
 * Dispatches 'time' when the time changes, and 'state' when it starts, stops or changes speed.
 */
export class Timeline extends EventTarget {
  /** @param {Model} model The model to play into. @param {Clock} clock The clock to set. */
  constructor(model, clock) {
    super();
    this._model = model;
    this._clock = clock;
    this._samples = [];
    this._times = [];
    /** @type {{next: number, offset: number, saved: object}[]} The model's state before some of the samples. */
    this._keyframes = [];
    this.marks = []; // the notable events, in order of time
    this.begin = this.time = 0;
    this.playing = false;
    this._speed = 1;
    this._next = 0;
    this._offset = 0;
    this._wall = null;
  }

  /** @returns {number} Seconds of the samples per wall second. */
  get speed() {
    return this._speed;
  }

  set speed(speed) {
    if (!(speed > 0)) throw new RangeError(`speed must be positive, got ${speed}`);
    this._speed = speed;
    this._tellRate();
  }

  /** Play; from the beginning, if it has ended. */
  play() {
    if (this.playing) return;
    if (this.time >= this.end) this.seek(this.begin);
    this.playing = true;
    this._wall = null;
    this._tellRate();
    this._schedule();
  }

  pause() {
    if (!this.playing) return;
    this.playing = false;
    this._tellRate();
  }

  /** Seek a time, and keep playing or pausing. */
  seek(time) {
    const to = Math.min(this.end, Math.max(this.begin, Number.isNaN(time) ? this.begin : time));
    const frame = this._keyframeBefore(to);
    if (to < this.time || frame.next > this._next) this._restore(frame);
    this.time = to;
    this._wall = null;
    this._show();
  }

  /**
   * Seek the next or the previous mark.
   * @param {number} direction 1 or -1.
   * @returns {Mark|null} The mark; null if there is none.
   */
  jump(direction) {
    const found = direction > 0
      ? this.marks.find((mark) => mark.t > this.time + JITTER)
      : this.marks.findLast((mark) => mark.t < this.time - JITTER);
    if (!found) return null;
    this.seek(found.t);
    return found;
  }

  /** Advance by the passed wall time, if it plays. */
  advance(wallMs) {
    if (!this.playing) return;
    const passed = this._wall === null ? 0 : Math.max(0, wallMs - this._wall) / 1000;
    this._wall = wallMs;
    this.time = Math.min(this.end, this.time + passed * this._speed);
    this._show(wallMs);
    if (this.time >= this.end) this.pause();
  }

  /** Bring the model to the current time. */
  _show(wallMs = performance.now()) {
    const { _times: times, _samples: samples } = this;
    let next = this._next;
    while (next < times.length && times[next] <= this.time) {
      this._model.receive(samples[next][1], samples[next][2]);
      this._offset = this.offsetAt(samples[next], times[next], this._offset);
      next += 1;
    }
    this._next = next;
    const simulated = this.time + this._offset;
    // Exact in each frame, as there are no delays here.
    this._clock.reset(simulated, wallMs);
    this._model.flush(simulated);
    this.dispatchEvent(new Event('time'));
  }

  _restore(frame) {
    this._model.restore(frame.saved);
    this._next = frame.next;
    this._offset = frame.offset;
  }

  _keyframeBefore(time) {
    const frames = this._keyframes;
    let [low, high] = [0, frames.length - 1];
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (this._times[frames[middle].next - 1] <= time) low = middle;
      else high = middle - 1;
    }
    return frames[low];
  }

  _tellRate() {
    this._clock.setRate(this._speed, !this.playing);
    this._clock.reset(this.time + this._offset, performance.now());
    this.dispatchEvent(new Event('state'));
  }

  _schedule() {
    const again = (wallMs) => {
      this.advance(wallMs ?? performance.now());
      if (this.playing) this._schedule();
    };
    if (globalThis.requestAnimationFrame) requestAnimationFrame(again);
    else setTimeout(again, 16);
  }
}

/** The playback of a recording. Dispatches 'ready' when seeking has become fast. */
export class Playback extends Timeline {
  constructor(recording, model, clock) {
    super(model, clock);
    this._samples = validSamples(recording.samples);
    this._times = timesOf(this._samples);
    model.unreadable += recording.samples.length - this._samples.length;
    this.name = recording.name;
    this.truncated = recording.truncated; // whether the recording's end is missing
    const count = this._times.length;
    this.begin = this.time = count ? this._times[0] : 0;
    this.end = count ? this._times[count - 1] : 0;
    this.marks = marksOf(this._samples, this._times);
    this._between = Math.max(MIN_BETWEEN, Math.ceil(count / MAX_KEYFRAMES));
    this._keyframes.push({ next: 0, offset: 0, saved: new Model().snapshot() });
    this.ready = false; // whether seeking is fast everywhere
    this._restore(this._keyframes[0]);
    this._show();
    this.prepared = this._prepare();
  }

  /** Yield all samples: time, key and payload. @returns {Iterable<[number, string, any]>} */
  *samples() {
    for (let i = 0; i < this._samples.length; i += 1) yield [this._times[i], this._samples[i][1], this._samples[i][2]];
  }

  /** Stop and release the recording. */
  close() {
    this.pause();
    this._closed = true;
  }

  /** Return the offset of simulated time to the recording's time at a sample. */
  offsetAt([, key, payload], time, before) {
    if (key !== '_world/events' && key !== '_world/scene') return before;
    const offset = secondsOf(payload.stamp) - time;
    return Math.abs(offset - before) > JITTER ? offset : before;
  }

  /** Create keyframes of the whole recording with a hidden model, in small steps. */
  async _prepare() {
    const model = new Model();
    let [next, offset] = [0, 0];
    while (next < this._samples.length && !this._closed) {
      const until = performance.now() + SLICE_MS;
      do {
        const to = Math.min(next + 100, this._samples.length);
        for (; next < to; next += 1) {
          model.receive(this._samples[next][1], this._samples[next][2]);
          offset = this.offsetAt(this._samples[next], this._times[next], offset);
          if ((next + 1) % this._between === 0) this._keyframes.push({ next: next + 1, offset, saved: model.snapshot() });
        }
      } while (next < this._samples.length && performance.now() < until);
      await new Promise((resolve) => setTimeout(resolve));
    }
    this.ready = true;
    this.dispatchEvent(new Event('ready'));
  }
}

/** Return the time of each sample in seconds, which never go back. */
function timesOf(samples) {
  const times = new Float64Array(samples.length);
  let [last, shift] = [-Infinity, 0];
  for (let i = 0; i < samples.length; i += 1) {
    const time = samples[i][0] * 1e-9;
    if (time + shift < last - JITTER) shift = last - time;
    last = Math.max(last, time + shift);
    times[i] = last;
  }
  return times;
}

/** Return the valid samples. */
function validSamples(samples) {
  let texts = {};
  return samples.filter(([, key, payload]) => {
    const valid = isValid(key, payload, texts);
    if (valid && key === '_world/view') texts = payload.events ?? {};
    return valid;
  });
}

/** The kind of mark of an event, if any, by the part that it changes. */
const MARKED = new Map(Object.entries({
  'robots.goals': ({ status }) => (status === ABORTED ? 'aborted' : undefined),
  faults: (_event, sets) => (sets?.active ? 'fault' : undefined),
  deadlocks: () => 'deadlock',
  scene: () => 'reset',
}));

function marksOf(samples, times) {
  const marks = [];
  const model = { texts: {}, world: new World() };
  samples.forEach(([, key, event], i) => {
    if (key === '_world/view') Object.assign(model, { texts: event.events ?? {}, world: new World(event.world) });
    if (key === '_world/events') marks.push(...markOf(event, times[i], model));
  });
  return marks;
}

/** Return the mark of an event at a time, if it is notable. @returns {Mark[]} */
export function markOf(event, t, model) {
  const kind = MARKED.get(partOf(event, model.texts))?.(event, model.texts[event.kind].sets);
  if (!kind) return [];
  const { subject, text } = describe(event, model);
  return [{ t, kind, text: `${subject} ${text}`.trim() }];
}
