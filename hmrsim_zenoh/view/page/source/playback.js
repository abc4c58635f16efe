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
 * Samples that are played into a model. Its times are simulated seconds that continue after a reset.
 *
 * Dispatches 'time' when the time changes, and 'state' when it starts, stops or changes speed.
 */
export class Timeline extends EventTarget {
  /** @param {{reset: Function, setRate: Function}} clock A `SimClock`, which is set. */
  constructor(model, clock) {
    super();
    this._model = model;
    this._clock = clock;
    /** @type {[number, string, any][]} Seconds, key and payload, in order of time. */
    this._samples = [];
    /** @type {{next: number, offset: number, saved: object}[]} The model's state before some of the samples. */
    this._keyframes = [];
    /** @type {Mark[]} The notable events, in order of time. */
    this.marks = [];
    this.begin = this.time = 0;
    this.playing = false;
    this._speed = 1;
    this._next = 0; // the index of the next sample
    this._offset = 0; // of simulated time
    this._wall = null;
  }

  /** @returns {number} Seconds of the samples per wall second. */
  get speed() { return this._speed; }

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
    const before = this._keyframes.findLast(({ next }) => next > 0 && this._samples[next - 1][0] <= to);
    const frame = before ?? this._keyframes[0];
    if (to < this.time || frame.next > this._next) this._restore(frame);
    this.time = to;
    this._wall = null;
    this._show();
  }

  /** Seek the next (1) or the previous (-1) mark. @returns {Mark|null} The mark; null if there is none. */
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

  /** Return the offset of simulated time at a sample. */
  offsetAt(_sample, before) { return before; }

  /** Bring the model to the current time. */
  _show(wallMs = performance.now()) {
    const { _samples: samples } = this;
    while (this._next < samples.length && samples[this._next][0] <= this.time) {
      const sample = samples[this._next++];
      this._model.receive(sample[1], sample[2]);
      this._offset = this.offsetAt(sample, this._offset);
    }
    const simulated = this.time + this._offset;
    // Exact in each frame, as there are no delays here.
    this._clock.reset(simulated, wallMs);
    this._model.flush(simulated);
    this.dispatchEvent(new Event('time'));
  }

  _restore({ saved, next, offset }) {
    this._model.restore(saved);
    this._next = next;
    this._offset = offset;
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

/** The playback of a recording. */
export class Playback extends Timeline {
  constructor({ name, samples, truncated }, model, clock) {
    super(model, clock);
    this._samples = inSeconds(validSamples(samples));
    model.unreadable += samples.length - this._samples.length;
    this.name = name;
    this.truncated = truncated; // whether the recording's end is missing
    this.begin = this.time = this._samples[0]?.[0] ?? 0;
    this.end = this._samples.at(-1)?.[0] ?? 0;
    this.marks = marksOf(this._samples);
    this._keyframes.push({ next: 0, offset: 0, saved: new Model().snapshot() });
    this._restore(this._keyframes[0]);
    this._show();
    this.prepared = this._prepare(); // resolves when seeking has become fast everywhere
  }

  /** @returns {[number, string, any][]} The seconds, key and payload of all samples. */
  samples() { return this._samples; }

  offsetAt([time, key, payload], before) {
    if (key !== '_world/events' && key !== '_world/scene') return before;
    const offset = secondsOf(payload.stamp) - time;
    return Math.abs(offset - before) > JITTER ? offset : before;
  }

  /** Create keyframes of the whole recording with a hidden model, in small steps. */
  async _prepare() {
    const between = Math.max(MIN_BETWEEN, Math.ceil(this._samples.length / MAX_KEYFRAMES));
    const model = new Model();
    let [offset, until] = [0, performance.now() + SLICE_MS];
    for (const [i, sample] of this._samples.entries()) {
      model.receive(sample[1], sample[2]);
      offset = this.offsetAt(sample, offset);
      if ((i + 1) % between === 0) this._keyframes.push({ next: i + 1, offset, saved: model.snapshot() });
      if (i % 100 || performance.now() < until) continue;
      await new Promise((resolve) => setTimeout(resolve));
      until = performance.now() + SLICE_MS;
    }
  }
}

/** Return samples with their times in seconds, which never go back, instead of nanoseconds. */
function inSeconds(samples) {
  let [last, shift] = [-Infinity, 0];
  return samples.map(([nanoseconds, key, payload]) => {
    const time = nanoseconds * 1e-9;
    if (time + shift < last - JITTER) shift = last - time;
    last = Math.max(last, time + shift);
    return [last, key, payload];
  });
}

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

function marksOf(samples) {
  let model = { texts: {}, world: new World() };
  return samples.flatMap(([time, key, payload]) => {
    if (key === '_world/view') model = { texts: payload.events ?? {}, world: new World(payload.world) };
    return key === '_world/events' ? markOf(payload, time, model) : [];
  });
}

/** Return the mark of an event at a time, if it is notable. @returns {Mark[]} @typedef {{t: number, kind: string, text: string}} Mark */
export function markOf(event, t, model) {
  const kind = MARKED.get(partOf(event, model.texts))?.(event, model.texts[event.kind].sets);
  if (!kind) return [];
  const { subject, text } = describe(event, model);
  return [{ t, kind, text: `${subject} ${text}`.trim() }];
}
