/** What sensors reach, as circles and wedges, and lines to what is seen. */

import { faint } from './glyphs.js';

const CROWD = 40; // with more robots in sight only the chosen one's sensors are shown

export function drawSensors(c, frame, poses) {
  const { camera, colours, selected, follow, hovered } = frame;
  const all = poses.count <= CROWD;
  for (let i = 0; i < poses.count; i++) {
    const robot = poses.robots[i];
    const chosen = robot.name === selected || robot.name === follow || robot.name === hovered;
    if (!robot.sensors.length || !(all || chosen)) continue;
    for (const sensor of robot.sensors) drawReach(c, frame, sensor, poses, i, chosen);
    if (!robot.detections.length) continue;
    c.beginPath();
    for (const { at } of robot.detections) {
      const px = camera.screenX(at[0]);
      const py = camera.screenY(at[1]);
      c.moveTo(poses.px[i], poses.py[i]);
      c.lineTo(px, py);
      c.moveTo(px + 9, py);
      c.arc(px, py, 9, 0, 2 * Math.PI);
    }
    c.strokeStyle = colours.sensor;
    c.lineWidth = 1.5;
    c.setLineDash([2, 3]);
    c.stroke();
    c.setLineDash([]);
  }
}

function drawReach(c, { camera, colours }, sensor, poses, i, chosen) {
  const radius = sensor.range * camera.scale;
  if (!(radius > 3)) return;
  const px = poses.px[i];
  const py = poses.py[i];
  const half = sensor.field_of_view ? sensor.field_of_view / 2 : Math.PI;
  const heading = poses.angle[i];
  c.beginPath();
  if (half < Math.PI) c.moveTo(px, py);
  c.arc(px, py, radius, heading - half, heading + half);
  c.closePath();
  c.fillStyle = faint(colours.sensor, sensor.blind ? 0 : chosen ? 0.16 : 0.07);
  c.fill();
  c.strokeStyle = sensor.blind ? colours.fault : faint(colours.sensor, chosen ? 0.8 : 0.4);
  c.lineWidth = 1;
  if (sensor.blind) c.setLineDash([4, 4]);
  c.stroke();
  c.setLineDash([]);
}
