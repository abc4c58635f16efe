// Keeps a Model in step with a simulator: first its scene, then each event at its time.

import { partOf, restarts } from '../model/changes.js';
import { isValid, secondsOf } from '../model/messages.js';
import { RequestError } from './connection.js';
import { Rewind } from './rewind.js';

/** Return a message if it has the shape of its key, else throw a RequestError. */
function valid(key, payload) {
  if (!isValid(key, payload)) throw new RequestError(`what is on ${key} can't be read`);
  return payload;
}

const RETRY = 1000; // ms
const BETWEEN = 750; // ms between two requests of the scene after entities have changed
const HIDDEN = 250; // ms between updates while the page is hidden
const MAX_WAITING = 20000; // events, beyond which they are all applied at once

/**
 * The live source of a model.
 *
 * Events: `state` when `state` changes; `time` when the rate of time may have changed.
 */
export class Live extends EventTarget {
  #connection;
  #clock;
  #getLog;
  /** Messages that are not shown yet, in order of time. @type {{at: number, key: string, payload: any}[]} */ #queue = [];
  #buffering = true; // whether there is no scene yet to apply events to
  /** What to request again. @type {'scene' | 'all' | null} */ #wanted = null;
  #turn = 0; // counts simulators, so that replies of an earlier one are dropped
  #asking = false;
  #answered = -Infinity; // ms; when the latest scene arrived
  /** @type {ReturnType<typeof setTimeout> | null} */ #soon = null;
  #dirty = false;
  /** @type {object | null} */ #scheduled = null; // the next step, if there is one
  /** @type {Record<string, {begin: () => void, stop: () => void}>} */ #watches = {};

  /** @type {'connecting' | 'live' | 'lost' | 'no server'} */
  state = 'connecting';
  timeState = null; // the latest `_world/time/state`

  /**
   * @param {import('./connection.js').Connection} connection
   * @param {import('./clock.js').SimClock} clock
   * @param {() => Promise<any[]>} [getLog] Gets events from before this page was opened.
   */
  constructor(connection, model, clock, getLog = async () => []) {
    super();
    this.#connection = connection;
    this.#clock = clock;
    this.rewind = new Rewind(model, clock);
    this.#getLog = getLog;
    const latest = { latest: true };
    const readable = (take) => (payload, key) => this.rewind.head.guard(key, () => take(valid(key, payload)));
    const info = (payload) => this.#change('_world/info', payload);
    connection.subscribe('_world/events', readable((event) => this.#receive(event)), {
      onLost: () => (this.#queue = [], this.#resync(true)),
    });
    connection.subscribe('_world/clock', readable(({ clock: stamp }) => clock.receive(secondsOf(stamp))), latest);
    const lostTime = () => this.#getTime().catch(() => {});
    connection.subscribe('_world/time/state', readable((state) => this.#receiveTime(state)), { ...latest, every: 0.2, onLost: lostTime });
    const lostInfo = () => connection.get('_world/info').then(info).catch(() => {});
    connection.subscribe('_world/info', info, { ...latest, onLost: lostInfo });
    connection.subscribe('*/battery_state', (battery, key) => this.#change(key, battery), { latest: true, every: 1 });
    connection.addEventListener('open', () => this.#become('connecting'));
    connection.addEventListener('close', () => this.#leave('no server'));
    connection.addEventListener('gone', () => this.#leave('lost'));
    connection.addEventListener('alive', () => {
      this.#forget();
      this.#resync(true);
    });
    if (connection.alive) this.#resync(true);
  }

  /** Follow the behavior trees, or stop following them. */
  watchTrees(on) { this.#watch('trees', on ? '*/_tree' : null, 0.2); }

  /** Follow the orders of the world, or stop following them. */
  watchDemand(on) {
    this.#watch('demand', on ? '_world/demand' : null, 0.2, (key, payload) => this.#await(key, payload));
  }

  /** Follow the detections of one robot, or of none. */
  watchDetections(robot) { this.#watch('detections', robot && `${robot}/detections`, 0.1); }

  /** Follow the feedback of one robot's goals, or of none. */
  watchFeedback(robot) { this.#watch('feedback', robot && `${robot}/*/_action/feedback`, 0.1); }

  /** Follow a key in place of the previous one of *name*: first its latest value, then what is published. */
  #watch(name, key, every, take = (from, payload) => this.#change(from, payload)) {
    this.#watches[name]?.stop();
    delete this.#watches[name];
    if (!key) return;
    const received = new Set();
    const connection = this.#connection;
    const begin = async () => {
      received.clear();
      // Feedback has no latest value, and neither has a robot without sensors or a tree.
      const replies = await connection.getAll(key).catch(() => []);
      if (this.#watches[name] !== watch) return;
      for (const [from, payload] of replies) if (!received.has(from)) take(from, payload);
    };
    const onSample = (payload, from) => (received.add(from), take(from, payload));
    const watch = { begin, stop: connection.subscribe(key, onSample, { latest: true, every, onLost: begin }) };
    this.#watches[name] = watch;
    if (!this.#buffering) void begin();
  }

  #receive(event) {
    const at = secondsOf(event.stamp);
    if (restarts(event, this.rewind.head.texts)) {
      // Show all earlier events first, as time may go back.
      this.#play(Infinity);
      if (!this.#buffering) this.#apply(at, '_world/events', event);
      this.#clock.reset(at);
      this.#resync(true);
      return;
    }
    this.#clock.receive(at);
    // An event ahead of later ones must not delay them.
    for (let i = this.#queue.length - 1; i >= 0 && this.#queue[i].at > at; i -= 1) this.#queue[i].at = at;
    this.#queue.push({ at, key: '_world/events', payload: event });
    const part = partOf(event, this.rewind.head.texts);
    // The event does not describe the entity completely.
    if (part === 'entities') this.#resyncSoon();
    if (part === 'simulation_state') void this.#getTime().catch(() => {});
    this.#schedule();
  }

  #receiveTime(state) {
    this.timeState = state;
    // In lockstep, and as fast as possible, time advances in bursts.
    this.#clock.setRate(state.clock === 'lockstep' ? 0 : state.real_time_factor, state.paused);
    this.#clock.receive(state.now);
    this.dispatchEvent(new Event('time'));
  }

  async #getTime() { this.#receiveTime(valid('_world/time/state', await this.#connection.get('_world/time/state'))); }

  /** Request the scene soon, but not too often, as it costs the simulator time. */
  #resyncSoon() {
    const wait = this.#asking ? BETWEEN : Math.max(0, this.#answered + BETWEEN - performance.now());
    this.#soon ??= setTimeout(() => {
      this.#soon = null;
      if (this.#asking) this.#resyncSoon();
      else void this.#resync(false);
    }, wait);
  }

  /**
   * Request the scene; with *all*, also the world.
   *
   * No event is missed, as events are subscribed to already; those from before the scene are dropped when it arrives.
   */
  async #resync(all) {
    this.#wanted = all || this.#buffering || this.#wanted === 'all' ? 'all' : 'scene';
    if (all) this.#buffering = true;
    if (this.#asking) return;
    this.#asking = true;
    const turn = this.#turn;
    while (turn === this.#turn && this.#wanted) {
      const wanted = this.#wanted;
      this.#wanted = null;
      const got = await this.#ask(wanted === 'all').catch((error) => error.name !== 'RequestError' && console.error(error));
      if (turn !== this.#turn) return;
      this.#answered = performance.now();
      // A reply from before everything was requested does not count.
      if (got && this.#wanted !== 'all' && this.#take(got)) continue;
      this.#wanted = wanted === 'all' ? wanted : (this.#wanted ?? wanted);
      if (!got || wanted === 'all') await new Promise((resolve) => setTimeout(resolve, RETRY));
      if (turn !== this.#turn) return;
    }
    if (turn === this.#turn) this.#asking = false;
  }

  async #ask(all) {
    const connection = this.#connection;
    const [view, info] = all
      ? await Promise.all([connection.get('_world/view', undefined, { timeout: 20 }), connection.get('_world/info')])
      : [];
    await this.#getTime();
    const scene = await connection.get('_world/scene', undefined, { timeout: 20 });
    const log = all && !this.rewind.head.events.length ? await this.#getLog().catch(() => []) : [];
    return { view: view && valid('_world/view', view), info, log, scene: valid('_world/scene', scene) };
  }

  /** Load a world, or queue a scene before all later events; return whether that is possible. */
  #take({ view, info, log, scene }) {
    const at = secondsOf(scene.stamp);
    if (view) {
      // A restart that was received before its kind was known: the scene may be older.
      const stale = this.#queue.some(({ key, payload }) => key === '_world/events' && restarts(payload, view.events ?? {}));
      if (stale) this.#queue = [];
      if (stale || !this.#apply(at, '_world/view', view)) return false;
      this.#apply(at, '_world/info', info);
      this.rewind.head.loadLog(log, at);
      this.#clock.reset(at);
      this.#queue = this.#queue.filter((item) => item.at >= at);
    }
    const index = this.#queue.findIndex((item) => item.at >= at);
    this.#queue.splice(index < 0 ? this.#queue.length : index, 0, { at, key: '_world/scene', payload: scene });
    this.#clock.receive(at);
    this.#buffering = false;
    const begins = view && at < this.rewind.latest;
    if (view) for (const { begin } of Object.values(this.#watches)) void begin();
    this.#play(this.#clock.live());
    if (begins) this.rewind.start(at);
    this.#schedule();
    this.#become('live');
    return true;
  }

  /** Apply a message to the model of the present. @returns {boolean} Whether it was valid. */
  #apply(at, key, payload) {
    const valid = this.rewind.head.receive(key, payload);
    if (valid) this.rewind.add(at, key, payload);
    return valid;
  }

  /** Tell the model the current time, so that it records what has not changed. */
  flush() {
    if (this.state === 'live') this.rewind.head.flush(this.#clock.live());
  }

  #change(key, payload) {
    // It belongs to a world that is not loaded yet.
    if (this.#buffering) return;
    this.#apply(this.#clock.live(), key, payload);
    this.#dirty = true;
    this.#schedule();
  }

  /** Queue a message by its stamp. */
  #await(key, payload) {
    // It belongs to a world that is not loaded yet.
    if (this.#buffering) return;
    this.rewind.head.guard(key, () => {
      // At most the latest received time, as time may stand.
      const at = Math.min(secondsOf(valid(key, payload).stamp), this.#clock.received ?? Infinity);
      const index = this.#queue.findLastIndex((item) => item.at <= at) + 1;
      this.#queue.splice(index, 0, { at, key, payload });
    });
    this.#schedule();
  }

  /** Apply all queued messages up to a time. */
  #play(until) {
    if (this.#buffering) return;
    let count = 0;
    while (count < this.#queue.length && this.#queue[count].at <= until) {
      const { at, key, payload } = this.#queue[count++];
      this.#apply(at, key, payload);
    }
    this.#queue.splice(0, count);
    if (count || this.#dirty) this.rewind.head.flush();
    this.#dirty = false;
  }

  /** Apply messages in the next frame, or by a timer, as a hidden page has no frames. */
  #schedule() {
    if (this.#buffering || this.#scheduled) return;
    const turn = (this.#scheduled = {});
    const step = () => {
      if (this.#scheduled !== turn) return;
      this.#scheduled = null;
      this.#play(this.#queue.length > MAX_WAITING ? Infinity : this.#clock.live());
      if (this.#queue.length) this.#schedule();
    };
    globalThis.requestAnimationFrame?.(step);
    setTimeout(step, HIDDEN);
  }

  #leave(state) {
    this.#forget();
    this.#become(state);
  }

  #forget() {
    ++this.#turn;
    this.#asking = false;
    this.#wanted = null;
    this.#buffering = true;
    this.#queue = [];
    clearTimeout(this.#soon ?? undefined);
    this.#soon = null;
  }

  #become(state) {
    if (state === this.state) return;
    this.state = state;
    this.dispatchEvent(new Event('state'));
  }
}
