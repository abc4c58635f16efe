/** Names of robots and items on plates, the most important first, where they cover no other name and no robot. */

import { inSight, isChosen, itemSize, stamp } from './robot_layer.js';
import { stroke } from './shapes.js';

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

  take(left, top, width, height) { this.walk(left, top, width, height, true); }

  /** Return whether a rectangle is free and completely on the screen. */
  free(left, top, width, height) {
    if (left < 0 || top < 0 || left + width > this.columns * CELL || top + height > this.rows * CELL) return false;
    return this.walk(left, top, width, height, false);
  }

  walk(left, top, width, height, mark) {
    const [x0, y0] = [Math.max(0, Math.floor(left / CELL)), Math.max(0, Math.floor(top / CELL))];
    const x1 = Math.min(this.columns - 1, Math.floor((left + width - 0.01) / CELL));
    const y1 = Math.min(this.rows - 1, Math.floor((top + height - 0.01) / CELL));
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
/** The directions around an object, best first. */
export const AROUND = [[0, 1], [0, -1], [1, 0], [-1, 0], [1, 1], [-1, 1], [1, -1], [-1, -1]];
/** The spots of a name, best first: direction, and css pixels away; a line leads to names that are away. */
const SPOTS = [0, 24, 48, 72].flatMap((away) => AROUND.map(([x, y]) => [x, y, away]));
const NEXT_TO = AROUND.length; // the number of spots without a line
const RANKS = { stopped: 0, offline: 0, waiting: 1, driving: 2, busy: 2, charging: 3, idle: 3 };
const LESSER = 2; // rank from which names are omitted if there are too many robots
const MANY = 1e6; // more than there are robots
const AGAIN = 200; // ms after which robots are ranked again, and names may return to their robots

export class Names {
  /** @param {import('./signs.js').Signs} signs The names of static objects. */
  constructor(sprites, signs) {
    this.sprites = sprites;
    this.signs = signs;
    this.room = new Room();
    this.spots = new Map(); // the last spot of each robot's name, so that it stays there if possible
    this.ranked = []; // the robots that may have names, the most important first
    /** @type {{name: string, left: number, top: number, sprite: import('./sprites.js').Sprite, to: number[]|null}[]} */
    this.placed = []; // the names on the map; a line leads to the object at *to*
    this.named = new Set();
    this.said = '';
    this.when = -Infinity;
  }

  draw(c, frame, poses, wallMs) {
    const { camera, layers, selected, hovered, follow, colors } = frame;
    const said = `${camera.scale} ${camera.width} ${poses.count} ${layers.names} ${selected} ${hovered} ${follow}`;
    const again = said !== this.said || !(wallMs - this.when < AGAIN);
    if (again) {
      Object.assign(this, { said, when: wallMs });
      this.rank(frame, poses);
    }
    this.place(frame, poses, again);
    c.beginPath();
    for (const { left, top, sprite, to } of this.placed) {
      if (to === null) continue;
      c.moveTo(...to);
      c.lineTo(left + sprite.width / 2, top + sprite.height / 2);
    }
    stroke(c, colors.muted, 1);
    for (const { left, top, sprite } of this.placed) stamp(c, sprite, left + sprite.width / 2, top + sprite.height / 2);
  }

  /** Rank the robots that may have names: chosen ones, then by state, then those that have a name already. */
  rank({ camera, clock, selected, follow, hovered, layers }, poses) {
    const chosen = [...new Set([selected, follow, hovered])].filter((name) => poses.index.has(name));
    this.ranked = chosen;
    if (!layers.names) return;
    const most = Math.floor((camera.width * camera.height) / ROOM);
    const now = clock.now();
    const ranks = new Float64Array(poses.count);
    for (let i = 0; i < poses.count; i++) {
      const { name } = poses.robots[i];
      // Whole numbers sort fast: rank, then index.
      ranks[i] = (2 * RANKS[poses.robots[i].stateAt(now)] + (this.named.has(name) ? 0 : 1)) * MANY + i;
    }
    for (const rank of ranks.sort()) {
      if (this.ranked.length >= most || (poses.count > most && rank / MANY / 2 >= LESSER)) break;
      const { name } = poses.robots[rank % MANY];
      if (!chosen.includes(name)) this.ranked.push(name);
    }
  }

  /** Place names where they cover nothing; those without room are omitted. @param {boolean} again Whether the best spot counts. */
  place(frame, poses, again) {
    const { camera, selected, layers, measures } = frame;
    this.placed.length = 0;
    this.room.reset(camera.width, camera.height);
    for (let i = 0; i < poses.count && poses.count <= CROWD; i++) {
      const radius = poses.radius[i];
      this.room.take(poses.px[i] - radius, poses.py[i] - radius, 2 * radius, 2 * radius);
    }
    for (const name of this.ranked) {
      const i = poses.index.get(name);
      if (i === undefined) continue;
      const sprite = this.sprites.name(name, name === selected);
      const spot = this.spot(poses, i, sprite, this.spots.get(name) ?? 0, again) ?? (isChosen(frame, { name }) ? 0 : null);
      if (spot === null) continue;
      this.spots.set(name, spot);
      this.put(name, ...corner(poses, i, sprite, spot), sprite, spot < NEXT_TO ? null : [poses.px[i], poses.py[i]]);
    }
    this.named = new Set(this.placed.map(({ name }) => name));
    if (layers.names && camera.scale * measures.meter >= ITEMS_NAMED) this.placeItems(frame);
  }

  put(name, left, top, sprite, to) {
    this.room.take(left, top, sprite.width, sprite.height);
    this.placed.push({ name, left, top, sprite, to });
  }

  /** Return a free spot, preferably the last one; null if none is free. */
  spot(poses, i, sprite, last, again) {
    const returns = again && last >= NEXT_TO;
    let found = null; // a spot that is free, but whose line crosses a name
    for (let k = returns ? 0 : -1; k < SPOTS.length; k++) {
      const spot = k < 0 ? last : k;
      const [left, top] = corner(poses, i, sprite, spot);
      if (!this.free(left, top, sprite)) continue;
      if (spot < NEXT_TO || this.sees(poses.px[i], poses.py[i], left + sprite.width / 2, top + sprite.height / 2)) return spot;
      found ??= spot;
    }
    return found;
  }

  free(left, top, { width, height }) {
    return this.room.free(left, top, width, height) && this.signs.free(left, top, width, height);
  }

  /** Return whether a line between two points crosses no name of a static object. */
  sees(x, y, toX, toY) {
    for (let share = 0.25; share < 0.9; share += 0.15) {
      if (!this.signs.free(x + (toX - x) * share - 1, y + (toY - y) * share - 1, 2, 2)) return false;
    }
    return true;
  }

  /** Place the names of items above them. */
  placeItems(frame) {
    const { camera, model } = frame;
    const away = itemSize(frame) / 2 + 1;
    for (const { name, at, carrier } of model.items.values()) {
      if (carrier || !at || !inSight(camera, at)) continue;
      const sprite = this.sprites.name(name, false);
      const left = camera.screenX(at[0]) - sprite.width / 2;
      const top = camera.screenY(at[1]) - away - sprite.height;
      if (this.free(left, top, sprite)) this.put(name, left, top, sprite, null);
    }
  }
}

const reused = [0, 0];

/** Return the upper left corner of a robot's name at a spot, in a reused array. */
function corner(poses, i, sprite, spot) {
  const [x, y, away] = SPOTS[spot];
  const beside = poses.radius[i] + 5 + away + sprite.width / 2;
  const below = poses.radius[i] + (poses.robots[i].battery && y > 0 ? 8 : 3) + away + sprite.height / 2;
  reused[0] = poses.px[i] + x * beside - sprite.width / 2;
  reused[1] = poses.py[i] + y * below - sprite.height / 2;
  return reused;
}
