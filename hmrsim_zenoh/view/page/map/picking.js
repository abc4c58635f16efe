/** The object below a point of the screen, and the tooltip that describes it. */

import { middle } from '../model/motion.js';
import { shareWords, taskWords, whyWords } from '../model/phrases.js';
import { nearestOn } from '../model/world.js';
import { el, say } from '../panels/dom.js';

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
    nearest('item', [...model.items.values()].filter(({ carrier }) => !carrier), point, reach * 0.8) ??
    nearest('dock', world.docks.values(), point, reach * 1.1) ??
    nearest('lift', model.lifts.values(), point, reach) ??
    nearest('place', world.places.values(), point, reach) ??
    doorAt(model, point, reach * 0.6) ??
    (layers.lanes ? nearest('waypoint', world.waypoints.values(), point, reach * 0.8) : null) ??
    (layers.lanes ? laneAt(world, point, reach * 0.7) : null) ?? { kind: 'floor', name: '', point }
  );
}

function robotAt({ camera }, poses, px, py) {
  let [found, least] = [-1, Infinity];
  for (let i = 0; i < poses.count; i++) {
    const far = Math.hypot(poses.px[i] - px, poses.py[i] - py);
    // Small robots have tolerance, but a nearer one wins.
    if (far < Math.max(REACH, poses.radius[i] + 3) && far <= least) [found, least] = [i, far];
  }
  if (found < 0) return null;
  const point = [camera.worldX(poses.px[found]), camera.worldY(poses.py[found])];
  return { kind: 'robot', name: poses.robots[found].name, point };
}

function nearest(kind, things, [x, y], reach) {
  let [found, least] = [null, reach];
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

export class Tooltip {
  /** @param {HTMLElement} element The container. */
  constructor(element) {
    this.box = el('div', { class: 'tooltip', role: 'tooltip' });
    element.append(this.box);
  }

  /** @param {string} text "" hides it */
  show(text, px, py, width) {
    say(this.box, text);
    if (!text) return;
    const left = px > width * 0.65 ? px - 14 - this.box.offsetWidth : px + 14;
    this.box.style.transform = `translate(${Math.max(4, Math.round(left))}px, ${Math.round(py + 16)}px)`;
  }
}

/** Return the tooltip of a picked object; "" for none. */
export function tooltipOf({ kind, name }, { model }, time) {
  const thing = model.allOf(kind)?.get(name);
  return thing ? TOOLTIPS[kind](thing, model, time) : '';
}

const TOOLTIPS = {
  robot(robot, model, time) {
    const state = robot.stateAt(time);
    const is = [state, whyWords(robot, state, model, time)].filter(Boolean).join(' ');
    const battery = robot.battery ? `\nbattery ${shareWords(robot.battery.percentage)}` : '';
    const goal = robot.goal ? `\n${taskWords(robot.goal, model.world)}` : '';
    return `${robot.name} · ${robot.type}, ${is}${goal}${battery}`;
  },
  item: ({ name, weight }) => `${name} · item${weight ? `, ${weight} kg` : ''}`,
  dock({ name, type, docked, queue }) {
    return `${name} · ${type}, ${docked.join(', ') || 'free'}${queue.length ? `; waiting: ${queue.join(', ')}` : ''}`;
  },
  door({ name, type, state, locked, jammed }) {
    return `${name} · ${type === 'door' ? '' : `${type} `}door, ${state}${locked ? ', locked' : ''}${jammed ? ', jammed' : ''}`;
  },
  lift: ({ name, stop, to }) => `${name} · lift at ${stop}${to ? `, on its way to ${to}` : ''}`,
  place: ({ name }) => `${name} · place`,
  waypoint: ({ name }) => `${name} · waypoint`,
  lane(lane, model) {
    const why = model.closureOf(lane);
    const room = lane.capacity === null ? '' : `, for ${lane.capacity}`;
    const limit = lane.speed_limit === null ? '' : `, at most ${lane.speed_limit} a second`;
    const closed = why === undefined ? '' : `\nclosed${why ? `: ${why}` : ''}`;
    return `${lane.from} ${lane.one_way ? '→' : '↔'} ${lane.to}${room}${limit}${closed}`;
  },
};
