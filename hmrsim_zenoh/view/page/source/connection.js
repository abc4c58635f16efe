// The page's connection to Zenoh: subscriptions and gets over one WebSocket that reconnects by itself.

const FIRST_PAUSE = 250; // ms before the second attempt, doubled before each further one
const MAX_PAUSE = 3000;

/** A failed get: an error reply, a timeout or no simulator. */
export class RequestError extends Error {
  constructor(message, details = []) {
    super(message);
    this.name = 'RequestError';
    this.details = details;
  }
}

/**
 * A connection to the server of this page, kept open.
 *
 * Events: `open` and `close` for the server, `alive` and `gone` for the simulator. After `open` one of the latter
 * follows. A second `alive` means another simulator.
 */
export class Connection extends EventTarget {
  /** @type {WebSocket | null} */ #socket = null;
  #subscriptions = new Map(); // the subscriptions by number
  #gets = new Map(); // how to settle the open requests, by number
  #lastId = 0;
  #pause = FIRST_PAUSE;
  /** @type {ReturnType<typeof setTimeout> | undefined} */ #timer;

  connected = false; // whether the server is connected
  alive = false; // whether the simulator is alive

  /** @param {string} url The server's WebSocket. */
  constructor(url) {
    super();
    this.url = url;
    // Reconnect at once when the network is back.
    globalThis.addEventListener?.('online', () => this.#connect());
    this.#connect();
  }

  /**
   * Subscribe to a key expression below the prefix, also across reconnections.
   * @param {{latest?: boolean, every?: number, onLost?: () => void}} [options] `latest`: only the newest sample of each
   * key, at most every `every` seconds; `onLost`: the page was too slow, and samples were lost
   * @returns {() => void} Unsubscribes.
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
   * Query a key, such as that of a service.
   * @param {{timeout?: number}} [options] seconds
   * @returns {Promise<any>} The payload of the first reply.
   */
  async get(key, payload = undefined, options = {}) { return (await this.#request(key, payload, options))[0][1]; }

  /** Query a key expression. @returns {Promise<[string, any][]>} The keys and payloads of all replies. */
  getAll(key, options = {}) { return this.#request(key, undefined, options); }

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

  #send(message) { this.#socket?.send(JSON.stringify(message)); }

  #ask(id, { key, latest, every }) { this.#send({ op: 'subscribe', id, key, latest, every }); }

  #take(message) {
    const { op, id, samples, alive, error } = message;
    if (op === 'samples') {
      // A subscription may have ended while a sample was on its way.
      for (const [from, key, payload] of samples) guarded(() => this.#subscriptions.get(from)?.onSample(payload, key));
    } else if (op === 'reply') this.#answer(message);
    else if (op === 'lost') guarded(() => this.#subscriptions.get(id)?.onLost?.());
    else if (op === 'alive') this.#tell(alive);
    else if (op === 'hello') this.#opened(alive);
    else console.error(`the server: ${error ?? JSON.stringify(message)}`);
  }

  #opened(alive) {
    this.connected = true;
    this.#pause = FIRST_PAUSE;
    for (const [id, subscription] of this.#subscriptions) this.#ask(id, subscription);
    this.dispatchEvent(new Event('open'));
    this.#tell(alive);
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

/** Log the error of a callback, so that the others still run. */
function guarded(call) {
  try {
    call();
  } catch (error) {
    console.error(error);
  }
}
