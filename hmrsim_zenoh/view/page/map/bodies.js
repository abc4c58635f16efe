/**
 * What robots look like: a colour and a shape for each type, so that types differ without their colours, too.
 * A body lies within the unit circle, which is its footprint, and looks along +x. Shapes are paths of SVG, in the
 * palette: pictures of `hmrsim map render` have the same.
 */

/**
 * @typedef {{types: string[], bodies: {types: string[], nose: string, small: string,
 *   rotors: {at: number, radius: number, body: number}}}} Palette
 * @typedef {{index: number, colour: string, shape: Path2D, nose: Path2D, small: Path2D,
 *   rotors: {at: number, radius: number, body: number}}} Look
 */

/**
 * Return how robots of a type look; of the first one, which is yellow, it is a cart.
 *
 * @param {number} index of the type in the world
 * @param {Palette} palette
 * @returns {Look}
 */
export function lookOf(index, { types, bodies }) {
  const [nose, small] = [new Path2D(bodies.nose), new Path2D(bodies.small)];
  const shape = new Path2D(bodies.types[index % bodies.types.length]);
  return { index, colour: types[index % types.length], shape, nose, small, rotors: bodies.rotors };
}

/** Draw a body that drives: its shape, and a wedge that shows where it looks. */
function drawDriving(c, look, outline, line) {
  c.fillStyle = look.colour;
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
  c.strokeStyle = outline;
  c.lineWidth = Math.max(0.13, line);
  c.lineCap = 'round';
  c.beginPath();
  for (const x of [-at, at]) for (const y of [-at, at]) c.moveTo(0, 0), c.lineTo(x, y);
  c.stroke();
  c.lineWidth = line;
  for (const x of [-at, at]) {
    for (const y of [-at, at]) {
      c.beginPath();
      c.arc(x, y, radius, 0, 2 * Math.PI);
      c.globalAlpha = 0.55;
      c.fillStyle = look.colour;
      c.fill();
      c.globalAlpha = 1;
      c.stroke();
    }
  }
  c.save();
  c.scale(body, body);
  drawDriving(c, look, outline, line / body);
  c.restore();
}

/** Draw a body in units of its footprint; *line* is the width of an outline in these units. */
export function drawBody(c, look, flies, outline, line) {
  (flies ? drawFlying : drawDriving)(c, look, outline, line);
}

/** Draw the little that is left of a robot that is a few pixels in size: an arrow's head. */
export function drawSmall(c, look, outline, line) {
  c.lineWidth = line;
  c.strokeStyle = outline;
  c.fillStyle = look.colour;
  c.fill(look.small);
  c.stroke(look.small);
}
