/** Names of what stands still, where there is room for them: places first, waypoints last. */

import { dockSize } from './fixtures.js';
import { faint } from './glyphs.js';
import { Room } from './room.js';

const FONT = '11px system-ui, -apple-system, "Segoe UI", Roboto, "Liberation Sans", sans-serif';
const HEIGHT = 13;
const BOLD = `600 ${FONT}`;

export class Signs {
  constructor() {
    this.room = new Room();
    this.widths = new Map();
    // A dock at a waypoint of its name needs it once.
    this.named = new Set();
  }

  draw(c, frame) {
    const { camera, world, measures, colours, layers } = frame;
    this.room.reset(camera.width, camera.height);
    for (const place of world.places.values()) drawPin(c, frame, place.at);
    if (!layers.names) return;
    const dock = dockSize(frame);
    const close = camera.scale * measures.metre;
    this.named.clear();
    this.kind(c, frame, world.places, colours.place, 8, close > (world.places.size > 60 ? 16 : 6), BOLD);
    this.kind(c, frame, world.docks, colours.muted, dock + 3, close > (world.docks.size > 20 ? 26 : 14));
    this.kind(c, frame, world.doors, colours.door, 7, close > (world.doors.size > 20 ? 40 : 22));
    this.kind(c, frame, world.lifts, colours.lift, dock + 5, close > 14);
    this.kind(c, frame, world.waypoints, colours.muted, 7, close > 38);
  }

  /** Write names below their spots, or above, or beside them. */
  kind(c, { camera, colours }, things, colour, gap, shown, font = FONT) {
    if (!shown) return;
    c.font = font;
    c.textAlign = 'center';
    c.textBaseline = 'middle';
    c.lineJoin = 'round';
    c.lineWidth = 3;
    c.strokeStyle = faint(colours.floor, 0.85);
    c.fillStyle = colour;
    for (const thing of things.values()) {
      const { name } = thing;
      const [x, y] = spotOf(thing);
      const px = camera.screenX(x);
      const py = camera.screenY(y);
      if (px < 0 || py < 0 || px > camera.width || py > camera.height) continue;
      const key = `${name}@${Math.round(px)},${Math.round(py)}`;
      if (this.named.has(key)) continue;
      const width = this.width(c, font, name);
      const beside = gap + width / 2 + 1;
      const below = gap + HEIGHT / 2;
      for (const [dx, dy] of [[0, below], [0, -below], [beside, 0], [-beside, 0]]) {
        const left = px + dx - width / 2 - 2;
        const top = py + dy - HEIGHT / 2;
        if (!this.room.free(left, top, width + 4, HEIGHT)) continue;
        this.room.take(left, top, width + 4, HEIGHT);
        c.strokeText(name, px + dx, py + dy);
        c.fillText(name, px + dx, py + dy);
        this.named.add(key);
        break;
      }
    }
  }

  width(c, font, name) {
    const key = font.length + name;
    let width = this.widths.get(key);
    if (width === undefined) this.widths.set(key, (width = c.measureText(name).width));
    return width;
  }
}

/** Return where the name of a thing belongs: of a door between its jambs, of a lift at its first stop. */
function spotOf({ at, points }) {
  if (points) return points[0];
  return Array.isArray(at[0]) ? [(at[0][0] + at[1][0]) / 2, (at[0][1] + at[1][1]) / 2] : at;
}

function drawPin(c, { camera, measures, colours }, [x, y]) {
  const px = camera.screenX(x);
  const py = camera.screenY(y);
  const size = Math.max(2.5, Math.min(5, 0.12 * measures.metre * camera.scale));
  c.beginPath();
  c.moveTo(px, py - size);
  c.lineTo(px + size, py);
  c.lineTo(px, py + size);
  c.lineTo(px - size, py);
  c.closePath();
  c.fillStyle = colours.place;
  c.fill();
  c.lineWidth = 1;
  c.strokeStyle = colours.floor;
  c.stroke();
}
