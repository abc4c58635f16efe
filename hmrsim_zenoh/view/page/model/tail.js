/**
 * The latest items of a list, of which copies are cheap: arrays only grow, so that copies share an array and differ in
 * length. Adding to the beginning of an array that has grown since takes a copy of it.
 *
 * @template T
 */
export class Tail {
  /** @param {number} most The number of kept items; temporarily up to half as many more. */
  constructor(most) {
    this._most = most;
    this.clear();
  }

  /** @returns {T[]} The kept items, oldest first. Do not change or keep this array. */
  get items() {
    if (this._kept.length !== this.length) this._kept = this._kept.slice(0, this.length);
    return this._kept;
  }

  /** @returns {T|undefined} The latest item. */
  get last() { return this._kept[this.length - 1]; }

  push(item) {
    if (this.length >= this._most * 1.5) this._kept = this._kept.slice(this.length - this._most + 1, this.length);
    this.items.push(item);
    this.length = this._kept.length;
  }

  clear() {
    this._kept = [];
    this.length = 0;
  }

  copy() { return Object.assign(new Tail(this._most), this); }
}
