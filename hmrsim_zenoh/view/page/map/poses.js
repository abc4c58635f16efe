/** Where the robots in sight are on the screen at an instant: arrays that are kept from frame to frame. */

export class Poses {
  constructor() {
    /** How many robots are in sight; only so many entries of the arrays count. */
    this.count = 0;
    /** @type {import('../model/robot.js').Robot[]} */
    this.robots = [];
    this.px = new Float32Array(0);
    this.py = new Float32Array(0);
    /** Css pixels. */
    this.radius = new Float32Array(0);
    /** Radians clockwise, as the canvas turns. */
    this.angle = new Float32Array(0);
    /** Whether it is still on its way; where it has arrived, nothing is ahead. */
    this.goes = [];
    this.pose = [0, 0, 0];
    /** Map of a name to its index, of all in sight. */
    this.index = new Map();
  }

  /** Look where everybody is. */
  look(frame, time) {
    const { camera, model, measures } = frame;
    const all = model.robots.size;
    if (this.px.length < all) {
      const room = Math.ceil(all * 1.5) + 16;
      for (const key of ['px', 'py', 'radius', 'angle']) this[key] = new Float32Array(room);
    }
    const least = all > 300 ? 4.9 : all > 60 ? 5.5 : 8;
    let count = 0;
    this.index.clear();
    for (const robot of model.robots.values()) {
      const pose = robot.poseAt(time, this.pose);
      const px = camera.screenX(pose[0]);
      const py = camera.screenY(pose[1]);
      const radius = Math.max(least, (robot.radius || measures.body) * camera.scale);
      const margin = radius + 30;
      if (px < -margin || py < -margin || px > camera.width + margin || py > camera.height + margin) continue;
      this.robots[count] = robot;
      this.px[count] = px;
      this.py[count] = py;
      this.radius[count] = radius;
      this.angle[count] = camera.flip * pose[2];
      this.goes[count] = robot.route.length > 0 && (robot.waits || robot.movesAt(time));
      this.index.set(robot.name, count);
      count++;
    }
    this.robots.length = count;
    this.count = count;
  }

  /** Return x, y and radius on the screen of a robot, or null if it is out of sight. */
  where(name) {
    const i = this.index.get(name);
    return i === undefined ? null : [this.px[i], this.py[i], this.radius[i]];
  }
}

/** Return whether any robot moves between two times. */
export function anyRobotMoves(model, before, now) {
  const least = Math.min(before, now);
  for (const robot of model.robots.values()) {
    if (robot.ends > least) return true;
  }
  return false;
}
