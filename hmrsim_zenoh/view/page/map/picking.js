/** What is below a point of the screen: robots before items, docks, doors, places, waypoints and lanes. */

const REACH = 12; // css pixels that a finger or pointer may be off

/**
 * @typedef {{kind: 'robot'|'item'|'dock'|'door'|'lift'|'place'|'waypoint'|'lane'|'floor', name: string,
 *   point: number[]}} Pick
 */

/** @returns {Pick} with the point that is meant: that of what is there, or the very point on lanes and on the floor */
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
    // One that is drawn small can be hit, too, but a nearer one wins.
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
    if (farFrom(point, a, b) <= reach) return { kind: 'door', name, point: [(a[0] + b[0]) / 2, (a[1] + b[1]) / 2] };
  }
  return null;
}

function farFrom([x, y], a, b) {
  const dx = b[0] - a[0];
  const dy = b[1] - a[1];
  const share = Math.min(1, Math.max(0, ((x - a[0]) * dx + (y - a[1]) * dy) / (dx * dx + dy * dy || 1)));
  return Math.hypot(a[0] + dx * share - x, a[1] + dy * share - y);
}

function laneAt(world, [x, y], reach) {
  const found = world.nearestLane(x, y, reach);
  return found && { kind: 'lane', name: found.lane.key, point: found.point };
}
