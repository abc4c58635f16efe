/** Names of robots and items: on plates, where there is room, and not on top of what else is written. */

import { inSight, itemSize, stamp } from './robot_layer.js';
import { Room } from './room.js';

const ROOM = 9000; // square css pixels a robot, of which with less only chosen ones have names
const CROWD = 400; // with more robots in sight names don't keep clear of robots
const ITEMS_NAMED = 34; // css pixels a metre
const SIDES = [[0, 1], [0, -1], [1, 0], [-1, 0]]; // where a name may be, best first

export class Names {
  /** @param {import('./sprites.js').Sprites} sprites @param {Room} signs what names of what stands still take */
  constructor(sprites, signs) {
    this.sprites = sprites;
    this.signs = signs;
    this.room = new Room();
    /** The side where each robot's name was last, so that it stays there while it can. */
    this.sides = new Map();
  }

  /** Write the names of chosen robots first; who has no room has none. */
  draw(c, frame, poses) {
    const { camera, selected, hovered, follow, layers } = frame;
    this.room.reset(camera.width, camera.height);
    for (let i = 0; i < poses.count && poses.count <= CROWD; i++) {
      const radius = poses.radius[i];
      this.room.take(poses.px[i] - radius, poses.py[i] - radius, 2 * radius, 2 * radius);
    }
    const chosen = [selected, follow, hovered];
    for (let k = 0; k < chosen.length; k++) {
      const i = poses.index.get(chosen[k]);
      if (i !== undefined && chosen.indexOf(chosen[k]) === k) this.place(c, poses, i, chosen[k] === selected, true);
    }
    if (!layers.names) return;
    const all = poses.count * ROOM <= camera.width * camera.height;
    for (let i = 0; i < poses.count && all; i++) {
      if (!chosen.includes(poses.robots[i].name)) this.place(c, poses, i, false, false);
    }
    if (camera.scale * frame.measures.metre >= ITEMS_NAMED) this.drawItems(c, frame);
  }

  place(c, poses, i, selected, always) {
    const { name } = poses.robots[i];
    const sprite = this.sprites.name(name, selected);
    const last = this.sides.get(name) ?? 0;
    let side = this.side(poses, i, sprite, last, true) ?? this.side(poses, i, sprite, last, false);
    if (side === null && !always) return;
    side ??= 0;
    this.sides.set(name, side);
    const [left, top] = corner(poses, i, sprite, side);
    this.room.take(left, top, sprite.width, sprite.height);
    stamp(c, sprite, left + sprite.width / 2, top + sprite.height / 2);
  }

  /** Return a side that is free, the last one if that is; null if none is. */
  side(poses, i, sprite, last, clear) {
    for (let k = -1; k < SIDES.length; k++) {
      const side = k < 0 ? last : k;
      const [left, top] = corner(poses, i, sprite, side);
      if (!this.room.free(left, top, sprite.width, sprite.height)) continue;
      if (!clear || this.signs.free(left, top, sprite.width, sprite.height)) return side;
    }
    return null;
  }

  /** Write the names of items above them. */
  drawItems(c, frame) {
    const { camera, model } = frame;
    const away = itemSize(frame) / 2 + 1;
    for (const { name, at, carrier } of model.items.values()) {
      if (carrier || !at || !inSight(camera, at)) continue;
      const sprite = this.sprites.name(name, false);
      const left = camera.screenX(at[0]) - sprite.width / 2;
      const top = camera.screenY(at[1]) - away - sprite.height;
      if (!this.room.free(left, top, sprite.width, sprite.height)) continue;
      this.room.take(left, top, sprite.width, sprite.height);
      stamp(c, sprite, left + sprite.width / 2, top + sprite.height / 2);
    }
  }
}

const spot = [0, 0];

/** Return the left upper corner of a robot's name on a side, in an array that is used again. */
function corner(poses, i, sprite, side) {
  const [x, y] = SIDES[side];
  const below = poses.radius[i] + (poses.robots[i].battery && y > 0 ? 8 : 3) + sprite.height / 2;
  spot[0] = poses.px[i] + x * (poses.radius[i] + 5 + sprite.width / 2) - sprite.width / 2;
  spot[1] = poses.py[i] + y * below - sprite.height / 2;
  return spot;
}
