/**
 * The latest items of a list, which can be saved and restored without copying.
 *
 * Arrays only grow, so that a saved state is an array and a length. Restoring the beginning of an array that has
 * grown since takes a copy.
 *
 * @template T
 */
export class Tail {
  /** @param {number} most The number of kept items; temporarily up to half as many more. */
  constructor(most) {
    this._most = most;
    this._kept = [];
    this._length = 0;
  }

  /** @returns {T[]} The kept items, oldest first. Do not change or keep this array. */
  get items() {
    if (this._kept.length !== this._length) this._kept = this._kept.slice(0, this._length);
    return this._kept;
  }

  get length() {
    return this._length;
  }

  /** @returns {T|undefined} The latest item. */
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

  /** @param {T[]} items The new content. */
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
