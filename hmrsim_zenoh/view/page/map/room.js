/** Which parts of the screen are taken, so that names don't lie on each other: a grid of cells, without allocation. */

const CELL = 8; // css pixels

export class Room {
  constructor() {
    this.cells = new Uint8Array(0);
    this.columns = 0;
    this.rows = 0;
  }

  /** Make all of it free. */
  reset(width, height) {
    this.columns = Math.ceil(width / CELL) + 1;
    this.rows = Math.ceil(height / CELL) + 1;
    if (this.cells.length < this.columns * this.rows) this.cells = new Uint8Array(this.columns * this.rows);
    else this.cells.fill(0);
  }

  /** Take a rectangle, whether it is free or not. */
  take(left, top, width, height) {
    this.walk(left, top, width, height, true);
  }

  /** Return whether a rectangle is free, all of it on the screen. */
  free(left, top, width, height) {
    if (left < 0 || top < 0 || left + width > this.columns * CELL || top + height > this.rows * CELL) return false;
    return this.walk(left, top, width, height, false);
  }

  walk(left, top, width, height, mark) {
    const x0 = Math.max(0, Math.floor(left / CELL));
    const x1 = Math.min(this.columns - 1, Math.floor((left + width - 1) / CELL));
    const y0 = Math.max(0, Math.floor(top / CELL));
    const y1 = Math.min(this.rows - 1, Math.floor((top + height - 1) / CELL));
    for (let y = y0; y <= y1; y++) {
      for (let x = x0; x <= x1; x++) {
        if (mark) this.cells[y * this.columns + x] = 1;
        else if (this.cells[y * this.columns + x]) return false;
      }
    }
    return true;
  }
}
