/**
 * The last so many of what is added, which can be saved and brought back without copying it.
 *
 * Arrays are only ever added to, so that what is saved is an array and a length; restoring the beginning of an
 * array that has grown since takes a copy.
 *
 * @template T
 */
export class Tail {
  /** @param {number} most How many are kept; up to half as many again for a while. */
  constructor(most) {
    this._most = most;
    /** @type {T[]} */
    this._kept = [];
    this._length = 0;
  }

  /** @returns {T[]} What is kept, oldest first; not to be changed. It may grow, or another take its place. */
  get items() {
    if (this._kept.length !== this._length) this._kept = this._kept.slice(0, this._length);
    return this._kept;
  }

  get length() {
    return this._length;
  }

  /** @returns {T|undefined} The one that was added last. */
  get last() {
    return this._length ? this._kept[this._length - 1] : undefined;
  }

  push(item) {
    if (this._length >= this._most * 1.5) this._kept = this._kept.slice(this._length - this._most + 1, this._length);
    else if (this._kept.length !== this._length) this._kept = this._kept.slice(0, this._length);
    this._kept.push(item);
    this._length = this._kept.length;
  }

  clear() {
    this._kept = [];
    this._length = 0;
  }

  /** @param {T[]} items What is kept from now on. */
  replace(items) {
    this._kept = items;
    this._length = items.length;
  }

  /** @returns {[T[], number]} What `restore` takes. */
  saved() {
    return [this._kept, this._length];
  }

  restore(saved) {
    [this._kept, this._length] = saved;
  }
}
