/** How large things are drawn: what a world in pixels has for a metre, and the box that is fitted to the screen. */

const METRE = { m: 1, px: 80 }; // units of the world that look like a metre
const ROAD = { m: 0.5, px: 18 }; // how wide a lane is
const BODY = { m: 0.25, px: 12 }; // radius of a robot without a footprint

/**
 * @typedef {{metre: number, road: number, body: number, box: number[]}} Measures
 * @param {import('../model/world.js').World} world
 * @returns {Measures}
 */
export function measuresOf(world) {
  const { units } = world;
  const box = world.bounds ?? around(world.extent, METRE[units]);
  return { metre: METRE[units], road: ROAD[units], body: BODY[units], box };
}

/** Return a box with a margin, and with room for something if there is none. */
function around([x0, y0, x1, y1], metre) {
  const margin = Math.max(metre * 0.8, 0.03 * Math.max(x1 - x0, y1 - y0));
  return [x0 - margin, y0 - margin, x1 + margin, y1 + margin];
}
