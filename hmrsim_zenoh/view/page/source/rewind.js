/** The past of a running simulation: what the page has received, as far as it is kept. */

import { Model } from '../model/model.js';
import { Timeline, markOf } from './playback.js';

const MOST = 100_000; // samples
const BETWEEN = 2000; // samples from one keyframe to the next
const DETAILED = 100; // robots beyond which batteries, trees and the like are kept only in keyframes
const NEXT_TO = 0.05; // seconds before the end that count as the end

/**
 * While it is active, the page shows a past time, and what is received changes a hidden model, `head`.
 *
 * Dispatches 'active' when the past is entered or left, besides the events of `Timeline`.
 */
export class Rewind extends Timeline {
  /** @type {Model | null} */ #hidden = null;
  #live; // the clock of the present
  #weight = 0; // of the samples since the latest keyframe, such as the number of robots in a scene

  /** @param {import('./clock.js').SimClock} clock The clock of the page, which is held at the past time. */
  constructor(model, clock) {
    super(model, { reset: (seconds) => this.active && clock.hold(seconds), setRate() {} });
    this.#live = clock;
  }

  /** @returns {boolean} Whether the page shows the past. */
  get active() { return this.#hidden !== null; }

  /** @returns {Model} The model of the present. */
  get head() { return this.#hidden ?? this._model; }

  /** @returns {number} The present. */
  get end() { return this.#live.live(); }

  /** @returns {number} The time that is shown. */
  get time() { return this.active ? this._past : this.end; }

  set time(seconds) { this._past = seconds; }

  /** @returns {number} The time of the latest sample; infinite before there is any. */
  get latest() { return this._keyframes.length ? (this._samples.at(-1)?.[0] ?? this.begin) : Infinity; }

  /** Keep the state of the present, from which the past begins. */
  start(time) {
    this.leave();
    Object.assign(this, { begin: time, time, marks: [], _samples: [], _keyframes: [], _next: 0 });
    this.#keep();
  }

  /** Keep a message that has changed the present. */
  add(time, key, payload) {
    if (!this._keyframes.length || (!key.startsWith('_world/') && this.head.robots.size > DETAILED)) return;
    const at = Math.max(time, this.latest);
    this._samples.push([at, key, payload]);
    if (key === '_world/events') this.marks.push(...markOf(payload, at, this.head));
    this.#weight += payload.robots?.length || 1;
    if (this.#weight < Math.max(BETWEEN, 4 * this.head.robots.size)) return;
    this.#keep();
    while (this._keyframes.slice(1).reduce((sum, { weight }) => sum + weight, 0) > MOST) this.#forget();
  }

  /** Keep the state of the present as a keyframe, with the weight of the samples before it. */
  #keep() {
    this._keyframes.push({ next: this._samples.length, offset: 0, saved: this.head.snapshot(), weight: this.#weight });
    this.#weight = 0;
  }

  /** Show a time; the present, if it is reached. */
  seek(time) {
    if (!this._keyframes.length) return;
    if (time >= this.end - NEXT_TO) return this.leave();
    const enters = !this.active;
    if (enters) {
      this.#hidden = new Model();
      this.#hidden.restore(this._model.snapshot());
      this.time = Infinity; // so that it is restored
    }
    super.seek(time);
    if (enters) this.dispatchEvent(new Event('active'));
  }

  advance(wallMs) {
    super.advance(wallMs);
    if (this.active && this.time >= this.end - NEXT_TO) this.leave();
  }

  /** Return to the present. */
  leave() {
    if (!this.active) return;
    this.pause();
    const head = this.#hidden;
    this.#hidden = null;
    this._model.restore(head.snapshot());
    this._model.unreadable += head.unreadable;
    this.#live.hold(null);
    this._model.flush();
    this.dispatchEvent(new Event('active'));
  }

  /** Forget the samples before the second keyframe. */
  #forget() {
    this._keyframes.shift();
    const [{ next }] = this._keyframes;
    this.begin = this._samples[next - 1][0];
    this._samples.splice(0, next);
    for (const frame of this._keyframes) frame.next -= next;
    this.marks = this.marks.filter(({ t }) => t >= this.begin);
    this._next -= next;
    if (this.active && this._next < 0) {
      this.time = Infinity;
      this.seek(this.begin);
    }
  }
}
