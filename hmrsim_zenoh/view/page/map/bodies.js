/**
 * What robots look like: a colour and a shape for each type, so that nobody has to tell them apart by colour alone.
 * A body lies within the unit circle, which is its footprint, and looks along +x.
 */

/** @typedef {{colour: string, shape: (c: CanvasRenderingContext2D) => void, index: number}} Look */

/** Trace a polygon with rounded corners through points of the unit circle. */
function rounded(c, points, radius) {
  const last = points[points.length - 1];
  c.moveTo((last[0] + points[0][0]) / 2, (last[1] + points[0][1]) / 2);
  points.forEach((point, i) => c.arcTo(...point, ...points[(i + 1) % points.length], radius));
  c.closePath();
}

function regular(corners, turned, size) {
  return Array.from({ length: corners }, (_, i) => {
    const angle = turned + (i * 2 * Math.PI) / corners;
    return [size * Math.cos(angle), size * Math.sin(angle)];
  });
}

const SHAPES = [
  (c) => c.roundRect(-0.7, -0.58, 1.44, 1.16, 0.26), // a cart
  (c) => rounded(c, [[0.92, 0], [0.3, 0.66], [-0.72, 0.6], [-0.72, -0.6], [0.3, -0.66]], 0.18), // an arrow's head
  (c) => c.roundRect(-0.84, -0.46, 1.68, 0.92, 0.1), // a long, angular one
  (c) => c.arc(0, 0, 0.78, 0, 2 * Math.PI), // a disc
  (c) => rounded(c, regular(6, 0, 0.88), 0.14), // a hexagon
  (c) => rounded(c, regular(4, 0, 0.94), 0.16), // a diamond
  (c) => rounded(c, [[0.8, 0.34], [0.34, 0.72], [-0.72, 0.72], [-0.72, -0.72], [0.34, -0.72], [0.8, -0.34]], 0.08),
  (c) => rounded(c, [[0.82, 0], [0.1, 0.4], [-0.8, 0.66], [-0.5, 0], [-0.8, -0.66], [0.1, -0.4]], 0.1), // a kite
];

/**
 * Return how robots of a type look; of the first one, which is yellow, it is a cart.
 *
 * @param {number} index of the type in the world
 * @param {string[]} colours
 * @returns {Look}
 */
export function lookOf(index, colours) {
  return { index, colour: colours[index % colours.length], shape: SHAPES[index % SHAPES.length] };
}

/** Draw a body that drives: its shape, and a wedge that shows where it looks. */
function drawDriving(c, look, outline, line) {
  c.beginPath();
  look.shape(c);
  c.fillStyle = look.colour;
  c.fill();
  c.lineWidth = line;
  c.strokeStyle = outline;
  c.stroke();
  c.beginPath();
  rounded(c, [[0.66, 0], [0.06, 0.36], [0.2, 0], [0.06, -0.36]], 0.05);
  c.fillStyle = outline;
  c.fill();
}

/** Draw a body that flies: its shape, small, between four rotors. */
function drawFlying(c, look, outline, line) {
  c.strokeStyle = outline;
  c.lineWidth = Math.max(0.13, line);
  c.lineCap = 'round';
  c.beginPath();
  for (const x of [-0.56, 0.56]) for (const y of [-0.56, 0.56]) c.moveTo(0, 0), c.lineTo(x, y);
  c.stroke();
  c.lineWidth = line;
  for (const x of [-0.56, 0.56]) {
    for (const y of [-0.56, 0.56]) {
      c.beginPath();
      c.arc(x, y, 0.37, 0, 2 * Math.PI);
      c.globalAlpha = 0.55;
      c.fillStyle = look.colour;
      c.fill();
      c.globalAlpha = 1;
      c.stroke();
    }
  }
  c.save();
  c.scale(0.62, 0.62);
  drawDriving(c, look, outline, line / 0.62);
  c.restore();
}

/** Draw a body in units of its footprint; *line* is the width of an outline in these units. */
export function drawBody(c, look, flies, outline, line) {
  (flies ? drawFlying : drawDriving)(c, look, outline, line);
}

/** Draw the little that is left of a robot that is a few pixels in size: an arrow's head. */
export function drawDot(c, look, outline, line) {
  c.beginPath();
  rounded(c, [[1, 0], [-0.8, 0.76], [-0.5, 0], [-0.8, -0.76]], 0.12);
  c.lineWidth = line;
  c.strokeStyle = outline;
  c.fillStyle = look.colour;
  c.fill();
  c.stroke();
}
