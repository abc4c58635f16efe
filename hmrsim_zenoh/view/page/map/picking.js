/** The object below a point of the screen, and the tooltip that describes it. */

import { middle } from '../model/motion.js';
import { nearestOn } from '../model/world.js';
import { shareWords, taskWords, whyWords } from '../model/phrases.js';

const REACH = 12; // css pixels of tolerance

/**
 * Return the object at a point of the screen, with its own point, or the very point on lanes and on the floor.
 * @returns {Pick} @typedef {{kind: string, name: string, point: number[]}} Pick
 */
export function pickAt(frame, poses, px, py) {
  const { camera, world, model, layers } = frame;
  const point = [camera.worldX(px), camera.worldY(py)];
  if (!world) return { kind: 'floor', name: '', point };
  const reach = REACH / camera.scale;
  return (
    robotAt(frame, poses, px, py) ??
    nearest('item', loose(model), point, reach * 0.8) ??
    nearest('dock', world.docks.values(), point, reach * 1.1) ??
    nearest('lift', model.lifts.values(), point, reach) ??
    nearest('place', world.places.values(), point, reach) ??
    doorAt(model, point, reach * 0.6) ??
    (layers.lanes ? nearest('waypoint', world.waypoints.values(), point, reach * 0.8) : null) ??
    (layers.lanes ? laneAt(world, point, reach * 0.7) : null) ?? { kind: 'floor', name: '', point }
  );
}

function robotAt({ camera }, poses, px, py) {
  let found = -1;
  let least = Infinity;
  for (let i = 0; i < poses.count; i++) {
    const far = Math.hypot(poses.px[i] - px, poses.py[i] - py);
    // Small robots have tolerance, but a nearer one wins.
    if (far < Math.max(REACH, poses.radius[i] + 3) && far <= least) [found, least] = [i, far];
  }
  if (found < 0) return null;
  const point = [camera.worldX(poses.px[found]), camera.worldY(poses.py[found])];
  return { kind: 'robot', name: poses.robots[found].name, point };
}

function* loose(model) {
  for (const item of model.items.values()) if (!item.carrier) yield item;
}

function nearest(kind, things, [x, y], reach) {
  let found = null;
  let least = reach;
  for (const thing of things) {
    const far = Math.hypot(thing.at[0] - x, thing.at[1] - y);
    if (far <= least) [found, least] = [thing, far];
  }
  return found && { kind, name: found.name, point: [...found.at] };
}

function doorAt(model, point, reach) {
  for (const { name, at: [a, b] } of model.doors.values()) {
    const [x, y] = nearestOn(a, b, ...point);
    if (Math.hypot(x - point[0], y - point[1]) <= reach) return { kind: 'door', name, point: middle(a, b) };
  }
  return null;
}

function laneAt(world, [x, y], reach) {
  const found = world.nearestLane(x, y, reach);
  return found && { kind: 'lane', name: found.lane.key, point: found.point };
}

const STYLE = `position:absolute;left:0;top:0;z-index:2;pointer-events:none;max-width:260px;padding:4px 8px;
border-radius:6px;font:12px/1.35 system-ui,-apple-system,'Segoe UI',Roboto,sans-serif;white-space:pre-line;
box-shadow:0 2px 8px rgb(0 0 0/.25);visibility:hidden`;

export class Tooltip {
  /** @param {HTMLElement} element The container. */
  constructor(element) {
    this.box = document.createElement('div');
    this.box.style.cssText = STYLE;
    this.box.setAttribute('role', 'tooltip');
    this.text = '';
    element.append(this.box);
  }

  /** @param {string} text "" hides it */
  show(text, px, py, width, colors) {
    if (text !== this.text) {
      this.text = text;
      this.box.textContent = text;
      this.box.style.visibility = text ? 'visible' : 'hidden';
      this.box.style.background = colors.ink;
      this.box.style.color = colors.background;
    }
    if (!text) return;
    const left = px > width * 0.65 ? px - 14 - this.box.offsetWidth : px + 14;
    this.box.style.transform = `translate(${Math.max(4, Math.round(left))}px, ${Math.round(py + 16)}px)`;
  }
}

/** Return the tooltip of a picked object; "" for none. */
export function tooltipOf({ kind, name }, { model, world }, time) {
  const thing = { robot: 'robots', item: 'items', dock: 'docks', door: 'doors', lift: 'lifts' }[kind];
  const now = thing && model[thing].get(name);
  switch (kind) {
    case 'robot': return now ? robotTooltip(now, model, time) : '';
    case 'item': return `${name} · item${now?.weight ? `, ${now.weight} kg` : ''}`;
    case 'dock': return `${name} · ${now.type}, ${now.docked.length ? now.docked.join(', ') : 'free'}${queue(now)}`;
    case 'door': return `${name} · ${now.type === 'door' ? '' : `${now.type} `}door, ${doorState(now)}`;
    case 'lift': return `${name} · lift at ${now.stop}${now.to ? `, on its way to ${now.to}` : ''}`;
    case 'place': return `${name} · place`;
    case 'waypoint': return `${name} · waypoint`;
    case 'lane': return laneTooltip(world.lanesByKey.get(name), model);
    default: return '';
  }
}

function robotTooltip(robot, model, time) {
  const state = robot.stateAt(time);
  const is = [state, whyWords(robot, state, model, time)].filter(Boolean).join(' ');
  const battery = robot.battery ? `\nbattery ${shareWords(robot.battery.percentage)}` : '';
  const goal = robot.goal ? `\n${taskWords(robot.goal, model.world)}` : '';
  return `${robot.name} · ${robot.type}, ${is}${goal}${battery}`;
}

function queue({ queue }) { return queue.length ? `; waiting: ${queue.join(', ')}` : ''; }

function doorState({ state, locked, jammed }) {
  return `${state}${locked ? ', locked' : ''}${jammed ? ', jammed' : ''}`;
}

function laneTooltip(lane, model) {
  if (!lane) return '';
  const why = model.closureOf(lane);
  const room = lane.capacity === null ? '' : `, for ${lane.capacity}`;
  const limit = lane.speed_limit === null ? '' : `, at most ${lane.speed_limit} a second`;
  const closed = why === undefined ? '' : `\nclosed${why ? `: ${why}` : ''}`;
  return `${lane.from} ${lane.one_way ? '→' : '↔'} ${lane.to}${room}${limit}${closed}`;
}
