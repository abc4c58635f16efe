/** Names of robots and items on plates, the most important first, where they cover no other text. */

import { inSight, itemSize, stamp } from './robot_layer.js';

const CELL = 8; // css pixels

/** The occupied parts of the screen as a grid of cells, so that names do not overlap. */
export class Room {
  constructor() {
    this.cells = new Uint8Array(0);
    this.columns = 0;
    this.rows = 0;
  }

  reset(width, height) {
    this.columns = Math.ceil(width / CELL) + 1;
    this.rows = Math.ceil(height / CELL) + 1;
    if (this.cells.length < this.columns * this.rows) this.cells = new Uint8Array(this.columns * this.rows);
    else this.cells.fill(0);
  }

  take(left, top, width, height) {
    this.walk(left, top, width, height, true);
  }

  /** Return whether a rectangle is free and completely on the screen. */
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

const ROOM = 7000; // square css pixels per robot below which only chosen and blocked robots have names
const CROWD = 400; // robots in sight above which names may cover robots
const ITEMS_NAMED = 34; // css pixels per meter
const SIDES = [[0, 1], [0, -1], [1, 0], [-1, 0], [1, 1], [-1, 1], [1, -1], [-1, -1]]; // the positions of a name, best first
const RANKS = { stopped: 0, offline: 0, waiting: 1, driving: 2, busy: 2, charging: 3, idle: 3 };
const LESSER = 2; // rank from which names are omitted if there are too many robots
const MANY = 1e6; // more than there are robots
const AGAIN = 200; // ms after which names are placed again; until then they move with their robots

export class Names {
  /** @param {import('./signs.js').Signs} signs The names of static objects. */
  constructor(sprites, signs) {
    this.sprites = sprites;
    this.signs = signs;
    this.room = new Room();
    this.sides = new Map(); // the last side of each robot's name, so that it stays there if possible
    this.placed = []; // robots with names, with the side, and whether they are chosen
    this.named = new Set();
    this.items = []; // items with names
    this.said = '';
    this.when = -Infinity;
  }

  draw(c, frame, poses, wallMs) {
    const { camera, layers, selected, hovered, follow } = frame;
    const said = `${camera.scale} ${camera.width} ${poses.count} ${layers.names} ${selected} ${hovered} ${follow}`;
    if (said !== this.said || !(wallMs - this.when < AGAIN)) {
      Object.assign(this, { said, when: wallMs });
      this.arrange(frame, poses);
    }
    for (const [name, side, chosen] of this.placed) {
      const i = poses.index.get(name);
      if (i === undefined) continue;
      const sprite = this.sprites.name(name, chosen);
      const [left, top] = corner(poses, i, sprite, side);
      stamp(c, sprite, left + sprite.width / 2, top + sprite.height / 2);
    }
    const away = itemSize(frame) / 2 + 1;
    for (const item of this.items) {
      if (item.carrier || !item.at) continue;
      const sprite = this.sprites.name(item.name, false);
      stamp(c, sprite, camera.screenX(item.at[0]), camera.screenY(item.at[1]) - away - sprite.height / 2);
    }
  }

  /** Place names, of chosen robots first; names without room are omitted. */
  arrange(frame, poses) {
    const { camera, selected, hovered, follow, layers } = frame;
    this.placed.length = this.items.length = 0;
    this.room.reset(camera.width, camera.height);
    for (let i = 0; i < poses.count && poses.count <= CROWD; i++) {
      const radius = poses.radius[i];
      this.room.take(poses.px[i] - radius, poses.py[i] - radius, 2 * radius, 2 * radius);
    }
    const chosen = [selected, follow, hovered];
    for (let k = 0; k < chosen.length; k++) {
      const i = poses.index.get(chosen[k]);
      if (i !== undefined && chosen.indexOf(chosen[k]) === k) this.place(poses, i, chosen[k] === selected, true);
    }
    if (!layers.names) return;
    const most = Math.floor((camera.width * camera.height) / ROOM);
    for (const [i, rank] of this.ranked(poses, frame.clock.now())) {
      if (this.placed.length >= most || (poses.count > most && rank >= LESSER)) break;
      if (!chosen.includes(poses.robots[i].name)) this.place(poses, i, false, false);
    }
    this.named = new Set(this.placed.map(([name]) => name));
    if (camera.scale * frame.measures.meter >= ITEMS_NAMED) this.placeItems(frame);
  }

  /** Return the robots in sight by importance: by state, then those that have a name already. */
  ranked(poses, now) {
    const ranks = new Float64Array(poses.count);
    for (let i = 0; i < poses.count; i++) {
      const { name } = poses.robots[i];
      // Whole numbers sort fast: rank, then index.
      ranks[i] = (2 * RANKS[poses.robots[i].stateAt(now)] + (this.named.has(name) ? 0 : 1)) * MANY + i;
    }
    return Array.from(ranks.sort(), (rank) => [rank % MANY, rank / MANY / 2]);
  }

  place(poses, i, selected, always) {
    const { name } = poses.robots[i];
    const sprite = this.sprites.name(name, selected);
    const last = this.sides.get(name) ?? 0;
    let side = this.side(poses, i, sprite, last, true);
    if (side === null && !always) return;
    side ??= this.side(poses, i, sprite, last, false);
    side ??= 0;
    this.sides.set(name, side);
    const [left, top] = corner(poses, i, sprite, side);
    this.room.take(left, top, sprite.width, sprite.height);
    this.placed.push([name, side, selected]);
  }

  /** Return a free side, preferably the last one; null if none is free. */
  side(poses, i, sprite, last, clear) {
    for (let k = -1; k < SIDES.length; k++) {
      const side = k < 0 ? last : k;
      const [left, top] = corner(poses, i, sprite, side);
      if (!this.room.free(left, top, sprite.width, sprite.height)) continue;
      if (!clear || this.signs.free(left, top, sprite.width, sprite.height)) return side;
    }
    return null;
  }

  /** Place the names of items above them. */
  placeItems(frame) {
    const { camera, model } = frame;
    const away = itemSize(frame) / 2 + 1;
    for (const item of model.items.values()) {
      const { name, at, carrier } = item;
      if (carrier || !at || !inSight(camera, at)) continue;
      const sprite = this.sprites.name(name, false);
      const left = camera.screenX(at[0]) - sprite.width / 2;
      const top = camera.screenY(at[1]) - away - sprite.height;
      if (!this.room.free(left, top, sprite.width, sprite.height)) continue;
      this.room.take(left, top, sprite.width, sprite.height);
      this.items.push(item);
    }
  }
}

const spot = [0, 0];

/** Return the upper left corner of a robot's name on a side, in a reused array. */
function corner(poses, i, sprite, side) {
  const [x, y] = SIDES[side];
  const below = poses.radius[i] + (poses.robots[i].battery && y > 0 ? 8 : 3) + sprite.height / 2;
  spot[0] = poses.px[i] + x * (poses.radius[i] + 5 + sprite.width / 2) - sprite.width / 2;
  spot[1] = poses.py[i] + y * below - sprite.height / 2;
  return spot;
}
