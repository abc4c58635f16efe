// Keeps a Model in step with a simulator: first its scene, then what happens, each thing at its own time.

/**
 * @typedef {import('./connection.js').Connection} Connection
 * @typedef {import('./clock.js').SimClock} SimClock
 * @typedef {import('../model/model.js').Model} Model
 * @typedef {{now: number, clock: string, real_time_factor: number, paused: boolean, epoch: number,
 *   participants: string[], waiting_for: string[], lag: number}} TimeState
 */

const RETRY = 1000; // ms
const HIDDEN = 250; // ms between looks while nobody sees the page
const MOST_WAITING = 20000; // events: whoever was away for so long need not see each at its time

/** What makes the scene another one, beyond what the event says. */
const CHANGES_SCENE = new Set(['teleported', 'spawned', 'deleted']);
/** What makes everything another one. */
const BEGINS_ANEW = new Set(['reset', 'world_loaded']);

/** @param {{sec: number, nanosec: number}} stamp */
const seconds = (stamp) => stamp.sec + stamp.nanosec / 1e9;

/**
 * The live source of a model.
 *
 * Events: `state` when `state` changes; `time` with the TimeState as detail when how time moves does.
 */
export class Live extends EventTarget {
  /** @type {Connection} */ #connection;
  /** @type {Model} */ #model;
  /** @type {SimClock} */ #clock;
  /** What is still to be shown, in order of time. @type {{at: number, event?: any, scene?: any}[]} */ #queue = [];
  #buffering = true; // there is no scene yet that events could be applied to
  /** What has to be asked for anew. @type {'scene' | 'all' | null} */ #wanted = null;
  #turn = 0; // counts the simulators that came and went: what was asked of another one is no answer
  #asking = false;
  #dirty = false;
  /** @type {(() => void) | null} */ #scheduled = null;
  #scheduledHidden = false;
  /** @type {Record<string, () => void>} */ #watches = {};

  /** @type {'connecting' | 'live' | 'lost' | 'no server'} */
  state = 'connecting';
  /** @type {TimeState | null} */
  timeState = null;

  /**
   * @param {Connection} connection
   * @param {Model} model
   * @param {SimClock} clock
   */
  constructor(connection, model, clock) {
    super();
    this.#connection = connection;
    this.#model = model;
    this.#clock = clock;
    const latest = { latest: true };
    connection.subscribe('_world/events', (event) => this.#hear(event), { onLost: () => this.#resync(false) });
    connection.subscribe('_world/clock', ({ clock: stamp }) => clock.hear(seconds(stamp)), latest);
    connection.subscribe('_world/time/state', (state) => this.#hearTime(state), { latest: true, every: 0.2 });
    connection.subscribe('_world/info', (info) => this.#change(() => model.loadInfo(info)), latest);
    connection.subscribe('*/battery_state', (battery, key) => this.#change(() => model.setBattery(owner(key), battery)), {
      latest: true,
      every: 1,
    });
    connection.addEventListener('open', () => this.#become('connecting'));
    connection.addEventListener('close', () => this.#leave('no server'));
    connection.addEventListener('gone', () => this.#leave('lost'));
    connection.addEventListener('alive', () => {
      this.#forget();
      this.#resync(true);
    });
    if (connection.alive) this.#resync(true);
  }

  /** Follow the behaviour trees, or don't. @param {boolean} on */
  watchTrees(on) {
    const take = (state, key) => this.#change(() => this.#model.setTree(owner(key), state));
    this.#watch('trees', on ? '*/_tree' : null, take, 0.2);
  }

  /** Follow what one robot's sensors see, or nobody's. @param {string | null} robot */
  watchDetections(robot) {
    const take = (found, key) => this.#change(() => this.#model.setDetections(owner(key), found));
    this.#watch('detections', robot && `${robot}/detections`, take, 0.1);
  }

  /** Follow how far one robot's goals are, or nobody's. @param {string | null} robot */
  watchFeedback(robot) {
    const take = (message, key) =>
      this.#change(() => this.#model.setFeedback(owner(key), key.split('/')[1], message));
    this.#watch('feedback', robot && `${robot}/*/_action/feedback`, take, 0.1);
  }

  /** Follow a key: its latest value, then what is published; in place of what *name* followed so far. */
  #watch(name, key, take, every) {
    this.#watches[name]?.();
    delete this.#watches[name];
    if (!key) return;
    const heard = new Set();
    const connection = this.#connection;
    const end = connection.subscribe(key, (payload, from) => (heard.add(from), take(payload, from)), {
      latest: true,
      every,
    });
    const getLatest = async () => {
      // Feedback has no latest, a robot without sensors nor anybody's tree has none either.
      const replies = await connection.getAll(key).catch(() => []);
      if (this.#watches[name] !== stop) return;
      for (const [from, payload] of replies) if (!heard.has(from)) take(payload, from);
    };
    const begin = () => (heard.clear(), void getLatest());
    const stop = () => (end(), connection.removeEventListener('alive', begin));
    this.#watches[name] = stop;
    connection.addEventListener('alive', begin);
    if (connection.alive) begin();
  }

  #hear(event) {
    const at = seconds(event.stamp);
    if (BEGINS_ANEW.has(event.kind)) {
      // What was before is over, and time may go back.
      this.#play(Infinity);
      if (!this.#buffering) this.#model.apply(event);
      this.#clock.reset(at);
      this.#resync(true);
      return;
    }
    this.#clock.hear(at);
    this.#queue.push({ at, event });
    if (CHANGES_SCENE.has(event.kind)) this.#resync(false);
    if (event.kind === 'simulation_state') void this.#getTime().catch(() => {});
    this.#schedule();
  }

  /** @param {TimeState} state */
  #hearTime(state) {
    this.timeState = state;
    // In lockstep, and as fast as possible, time moves in bursts.
    this.#clock.setRate(state.clock === 'lockstep' ? 0 : state.real_time_factor, state.paused);
    this.#clock.hear(state.now);
    this.dispatchEvent(new CustomEvent('time', { detail: state }));
  }

  async #getTime() {
    this.#hearTime(await this.#connection.get('_world/time/state'));
  }

  /**
   * Get the scene anew; with *all* the world, too, as there is another one, or we know none.
   *
   * Events are subscribed to already, so none is missed: those from before the scene are dropped when it is there.
   *
   * @param {boolean} all
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
      const got = await this.#ask(wanted === 'all').catch(complain);
      if (turn !== this.#turn) return;
      if (!got) await new Promise((resolve) => setTimeout(resolve, RETRY));
      // Not what was asked for before somebody wanted all.
      if (got && this.#wanted !== 'all') this.#take(got);
      else this.#wanted = wanted === 'all' ? wanted : (this.#wanted ?? wanted);
    }
    if (turn === this.#turn) this.#asking = false;
  }

  /** @param {boolean} all */
  async #ask(all) {
    const connection = this.#connection;
    const [current, info] = all
      ? await Promise.all([connection.get('_world/get_current_world', {}, { timeout: 20 }), connection.get('_world/info')])
      : [];
    await this.#getTime();
    const scene = await connection.get('_world/scene', undefined, { timeout: 20 });
    return { world: current && JSON.parse(current.world.world_resource.resource_string), info, scene };
  }

  /** Show another world, or put a scene among what happens: before all that is not older. */
  #take({ world, info, scene }) {
    const at = seconds(scene.stamp);
    if (world) {
      this.#model.loadWorld(world);
      this.#model.loadInfo(info);
      this.#clock.reset(at);
      this.#queue = this.#queue.filter((item) => item.at >= at);
    }
    const index = this.#queue.findIndex((item) => item.at >= at);
    this.#queue.splice(index < 0 ? this.#queue.length : index, 0, { at, scene });
    this.#clock.hear(at);
    this.#buffering = false;
    this.#play(this.#clock.now());
    this.#schedule();
    this.#become('live');
  }

  /** @param {() => void} change */
  #change(change) {
    // Of a world that we don't know yet.
    if (this.#buffering) return;
    change();
    this.#dirty = true;
    this.#schedule();
  }

  /** Show what has happened by then. @param {number} until */
  #play(until) {
    if (this.#buffering) return;
    let count = 0;
    while (count < this.#queue.length && this.#queue[count].at <= until) {
      const { event, scene } = this.#queue[count++];
      if (scene) this.#model.loadScene(scene);
      else this.#model.apply(event);
    }
    this.#queue.splice(0, count);
    if (count || this.#dirty) this.#model.flush();
    this.#dirty = false;
  }

  /** Play with the next frame, or soon where there are none as nobody looks. */
  #schedule() {
    const hidden = !globalThis.requestAnimationFrame || globalThis.document?.hidden === true;
    if (this.#buffering || (this.#scheduled && (!hidden || this.#scheduledHidden))) return;
    this.#scheduled?.();
    const step = () => {
      this.#scheduled = null;
      this.#play(this.#queue.length > MOST_WAITING ? Infinity : this.#clock.now());
      if (this.#queue.length) this.#schedule();
    };
    const id = hidden ? setTimeout(step, HIDDEN) : requestAnimationFrame(step);
    this.#scheduledHidden = hidden;
    this.#scheduled = () => (hidden ? clearTimeout(id) : cancelAnimationFrame(id));
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
  }

  #become(state) {
    if (state === this.state) return;
    this.state = state;
    this.dispatchEvent(new Event('state'));
  }
}

/** Whose a key is. @param {string} key */
function owner(key) {
  return key.split('/', 1)[0];
}

/** Say what is wrong with us; what is wrong with the simulator will be asked again. @param {Error} error */
function complain(error) {
  if (error.name !== 'RequestError') console.error(error);
}
