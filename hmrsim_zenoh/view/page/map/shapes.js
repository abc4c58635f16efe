/**
 * The bodies of robots, with a color and a shape for each type so that types differ without their colors, and small signs.
 * A body lies within the unit circle, which is its footprint, and faces +x. Its shapes are SVG paths in the palette, as
 * in pictures of `hmrsim map render`. Signs are paths, too, so that they look the same everywhere.
 */

/**
 * Return the look of a robot type; the first type is a yellow cart.
 * @param {number} index The index of the type in the world.
 */
export function lookOf(index, { types, bodies }) {
  const [nose, small] = [new Path2D(bodies.nose), new Path2D(bodies.small)];
  const shape = new Path2D(bodies.types[index % bodies.types.length]);
  return { index, color: types[index % types.length], shape, nose, small, rotors: bodies.rotors };
}

/** Stroke the current path. @param {number[]} [dash] Lengths of dashes and gaps, for this path only. */
export function stroke(c, color, width, dash) {
  c.strokeStyle = color;
  c.lineWidth = width;
  if (dash) c.setLineDash(dash);
  c.stroke();
  if (dash) c.setLineDash([]);
}

/** Fill the current path. */
export function fill(c, color) {
  c.fillStyle = color;
  c.fill();
}

/** Add a line through points of the world to the current path. */
export function trace(c, camera, points, closed = false) {
  points.forEach((at, i) => (i ? c.lineTo(...camera.toScreen(at)) : c.moveTo(...camera.toScreen(at))));
  if (closed) c.closePath();
}

/** Begin a path with a circle. */
export function circle(c, x, y, radius) {
  c.beginPath();
  c.arc(x, y, radius, 0, 2 * Math.PI);
}

/** Draw a body that drives: its shape, and a wedge that shows the heading. */
function drawDriving(c, look, outline, line) {
  c.fillStyle = look.color;
  c.fill(look.shape);
  c.lineWidth = line;
  c.strokeStyle = outline;
  c.stroke(look.shape);
  c.fillStyle = outline;
  c.fill(look.nose);
}

/** Draw a body that flies: its shape, small, between four rotors. */
function drawFlying(c, look, outline, line) {
  const { at, radius, body } = look.rotors;
  Object.assign(c, { strokeStyle: outline, lineWidth: Math.max(0.13, line), lineCap: 'round' });
  c.beginPath();
  for (const x of [-at, at]) for (const y of [-at, at]) c.moveTo(0, 0), c.lineTo(x, y);
  c.stroke();
  c.lineWidth = line;
  for (const x of [-at, at]) {
    for (const y of [-at, at]) {
      circle(c, x, y, radius);
      c.globalAlpha = 0.55;
      fill(c, look.color);
      c.globalAlpha = 1;
      c.stroke();
    }
  }
  within(c, 0, 0, body, () => drawDriving(c, look, outline, line / body));
}

/** Draw a body in units of its footprint; *line* is the width of an outline in these units. */
export function drawBody(c, look, flies, outline, line) { (flies ? drawFlying : drawDriving)(c, look, outline, line); }

/** Draw a robot of a few pixels, as an arrowhead. */
export function drawSmall(c, look, outline, line) {
  Object.assign(c, { lineWidth: line, strokeStyle: outline, fillStyle: look.color });
  c.fill(look.small);
  c.stroke(look.small);
}

/** Begin a path with a rectangle that has round corners. */
export function plate(c, x, y, width, height, radius) {
  c.beginPath();
  c.roundRect(x, y, width, height, radius);
}

/** Begin a path with lines from point to point. */
export function polyline(c, points) {
  c.beginPath();
  for (const [x, y] of points) c.lineTo(x, y);
}

/** Begin a path with a polygon. */
export function polygon(c, corners) {
  polyline(c, corners);
  c.closePath();
}

/** Signs as SVG paths that fill the unit circle. */
const GLYPHS = {
  bolt: 'M.12-.68L-.46 .12H-.06L-.14 .68L.46-.16H.06z',
  dots: [-0.46, 0, 0.46].map((x) => `M${x - 0.17} 0a.17 .17 0 1 0 .34 0a.17 .17 0 1 0-.34 0`).join(''),
  exclamation: 'M0-.62a.15 .13 0 0 1 .15 .13V.01a.15 .13 0 0 1-.3 0V-.49a.15 .13 0 0 1 .15-.13M-.18 .47a.18 .18 0 1 0 .36 0a.18 .18 0 1 0-.36 0',
  cross: 'M-.5-.3L-.3-.5L0-.2L.3-.5L.5-.3L.2 0L.5 .3L.3 .5L0 .2L-.3 .5L-.5 .3L-.2 0z',
  disc: 'M-.38 0a.38 .38 0 1 0 .76 0a.38 .38 0 1 0-.76 0',
  lock: 'M-.45-.1H-.37V-.14a.37 .37 0 0 1 .74 0V-.1H.45V.56H-.45zM-.19-.1H.19V-.14a.19 .19 0 0 0-.38 0z',
};

/** The glyphs of robots' states; other states have none. */
export const STATE_GLYPHS = { waiting: 'dots', charging: 'bolt', stopped: 'exclamation', offline: 'cross', busy: 'disc' };

/** Draw a glyph within a circle. */
export function drawGlyph(c, glyph, x, y, radius, color) {
  within(c, x, y, radius, () => {
    c.fillStyle = color;
    c.fill(new Path2D(GLYPHS[glyph]), 'evenodd');
  });
}

/** Return black or white, whichever is easier to read on a color. @param {string} color #rrggbb */
export function inkOn(color) {
  const [r, g, b] = [1, 3, 5].map((i) => (parseInt(color.slice(i, i + 2), 16) / 255) ** 2.2);
  return 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.3 ? '#11151c' : '#ffffff';
}

/** Return a color with an opacity. @param {string} color #rrggbb */
export function faint(color, share) { return color + Math.round(share * 255).toString(16).padStart(2, '0'); }

/** Return a mix of two colors. @param {number} share Of the second, from 0 to 1. */
export function mixed(one, other, share) {
  const part = (color, i) => parseInt(color.slice(i, i + 2), 16);
  return `rgb(${[1, 3, 5].map((i) => Math.round(part(one, i) * (1 - share) + part(other, i) * share)).join()})`;
}

/** Draw within the unit circle that is scaled to a circle on the screen. */
export function within(c, x, y, radius, draw) {
  c.save();
  c.translate(x, y);
  c.scale(radius, radius);
  draw();
  c.restore();
}

/** Draw a glyph on a disc. */
export function drawBadge(c, glyph, x, y, radius, color, edge) {
  circle(c, x, y, radius);
  fill(c, color);
  stroke(c, edge, 1.5);
  drawGlyph(c, glyph, x, y, radius, inkOn(color));
}

/** Draw a triangle with an exclamation mark. */
export function drawWarning(c, x, y, radius, color, edge) {
  polygon(c, [[x, y - radius], [x + 0.98 * radius, y + 0.78 * radius], [x - 0.98 * radius, y + 0.78 * radius]]);
  c.lineJoin = 'round';
  stroke(c, edge, 0.5 * radius);
  stroke(c, color, 0.22 * radius);
  fill(c, color);
  drawGlyph(c, 'exclamation', x, y + 0.18 * radius, 0.72 * radius, inkOn(color));
}
