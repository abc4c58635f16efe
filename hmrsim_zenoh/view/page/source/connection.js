// The page's Zenoh: subscriptions and gets over one WebSocket, which comes back by itself.

const FIRST_PAUSE = 250; // ms before the second try, twice as long before each further one
const MAX_PAUSE = 3000;

/** Why a get has no answer: Zenoh's error reply, a timeout, no simulator. */
export class RequestError extends Error {
  constructor(message, details = []) {
    super(message);
    this.name = 'RequestError';
    this.details = details;
  }
}

/**
 * @typedef {object} Subscription
 * @property {string} key
 * @property {(payload: any, key: string) => void} onSample
 * @property {boolean} latest
 * @property {number} every
 * @property {(() => void) | undefined} onLost
 */

/**
 * A connection to the server of this page, kept up for ever.
 *
 * Events: `open` and `close` (the server came, went), `alive` and `gone` (the simulator did). After `open` one of the
 * latter follows; `alive` twice is another simulator.
 */
export class Connection extends EventTarget {
  /** @type {WebSocket | null} */ #socket = null;
  /** @type {Map<number, Subscription>} */ #subscriptions = new Map();
  /** @type {Map<number, {resolve: (replies: [string, any][]) => void, reject: (error: Error) => void}>} */
  #gets = new Map();
  #lastId = 0;
  #pause = FIRST_PAUSE;
  /** @type {ReturnType<typeof setTimeout> | undefined} */ #timer;

  /** Whether the server is there. */
  connected = false;
  /** Whether the simulator is. */
  alive = false;
  /** What the server said first: prefix, version, … @type {Record<string, any>} */
  hello = {};

  /** @param {string} url where the server's WebSocket is */
  constructor(url) {
    super();
    this.url = url;
    // The network is back: why wait?
    globalThis.addEventListener?.('online', () => this.#connect());
    this.#connect();
  }

  /**
   * Call back with the samples of a key expression below the prefix, also after the server was away.
   * @param {{latest?: boolean, every?: number, onLost?: () => void}} [options] `latest`: only the newest sample of each
   * key, at most each `every` seconds; `onLost`: we were too slow, and some are lost
   * @returns {() => void} what ends it
   */
  subscribe(key, onSample, { latest = false, every = 0.05, onLost } = {}) {
    const id = ++this.#lastId;
    const subscription = { key, onSample, latest, every, onLost };
    this.#subscriptions.set(id, subscription);
    if (this.connected) this.#ask(id, subscription);
    return () => {
      if (this.#subscriptions.delete(id) && this.connected) this.#send({ op: 'unsubscribe', id });
    };
  }

  /**
   * Ask what answers on a key, such as a service of the simulator.
   * @param {{timeout?: number}} [options] seconds
   * @returns {Promise<any>} what the first reply says
   */
  async get(key, payload = undefined, options = {}) {
    const replies = await this.#request(key, payload, options);
    return replies[0][1];
  }

  /**
   * Ask all that answer on a key expression.
   * @param {{timeout?: number}} [options] seconds
   * @returns {Promise<[string, any][]>} their keys, and what they say
   */
  getAll(key, options = {}) {
    return this.#request(key, undefined, options);
  }

  #request(key, payload, { timeout = 5 }) {
    if (!this.connected) return Promise.reject(new RequestError('the server of this page is not there'));
    const id = ++this.#lastId;
    return new Promise((resolve, reject) => {
      this.#gets.set(id, { resolve, reject });
      this.#send({ op: 'get', id, key, payload, timeout });
    });
  }

  #connect() {
    if (this.#socket) return;
    clearTimeout(this.#timer);
    const socket = new WebSocket(this.url);
    this.#socket = socket;
    socket.onmessage = (event) => this.#take(JSON.parse(event.data));
    socket.onclose = () => this.#closed();
  }

  #closed() {
    const was = this.connected;
    this.#socket = null;
    this.connected = this.alive = false;
    this.#timer = setTimeout(() => this.#connect(), this.#pause);
    this.#pause = Math.min(2 * this.#pause, MAX_PAUSE);
    const gets = [...this.#gets.values()];
    this.#gets.clear();
    for (const { reject } of gets) reject(new RequestError('the server of this page went away'));
    if (was) this.dispatchEvent(new Event('close'));
  }

  #send(message) {
    this.#socket?.send(JSON.stringify(message));
  }

  #ask(id, { key, latest, every }) {
    this.#send({ op: 'subscribe', id, key, latest, every });
  }

  #take(message) {
    switch (message.op) {
      case 'samples':
        for (const [id, key, payload] of message.samples) {
          // Not there any more: it was sent before the server knew that it is not wanted.
          const subscription = this.#subscriptions.get(id);
          if (subscription) guarded(() => subscription.onSample(payload, key));
        }
        break;
      case 'reply':
        this.#answer(message);
        break;
      case 'lost':
        guarded(() => this.#subscriptions.get(message.id)?.onLost?.());
        break;
      case 'alive':
        this.#tell(message.alive);
        break;
      case 'hello':
        this.#opened(message);
        break;
      default:
        console.error(`the server: ${message.error ?? JSON.stringify(message)}`);
    }
  }

  #opened(hello) {
    this.hello = hello;
    this.connected = true;
    this.#pause = FIRST_PAUSE;
    for (const [id, subscription] of this.#subscriptions) this.#ask(id, subscription);
    this.dispatchEvent(new Event('open'));
    this.#tell(hello.alive);
  }

  #tell(alive) {
    this.alive = alive;
    this.dispatchEvent(new Event(alive ? 'alive' : 'gone'));
  }

  #answer({ id, replies, error, details }) {
    const get = this.#gets.get(id);
    this.#gets.delete(id);
    if (error === undefined) get?.resolve(replies);
    else get?.reject(new RequestError(error, details));
  }
}

/** Go on whatever one callback does: the others have theirs to do. */
function guarded(call) {
  try {
    call();
  } catch (error) {
    console.error(error);
  }
}
