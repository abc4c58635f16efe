// The page's requests to the simulator, with the keys and messages of any client (docs/reference/keys.md).

const DONE = 1; // of simulation_interfaces/msg/Result
const PLAYING = 1;
const PAUSED = 2;
const STEP_TIMEOUT = 60; // seconds, as the answer arrives after the steps

/** Return a geometry_msgs/msg/PoseStamped on the map. @param {number} yaw In radians. */
export function poseStamped(x, y, yaw) {
  return { header: { frame_id: 'map' }, pose: { position: { x, y }, orientation: { z: Math.sin(yaw / 2), w: Math.cos(yaw / 2) } } };
}

/** All of them throw an error with the reason if the simulator refuses. */
export class Commands {
  constructor(connection, model, clock) {
    Object.assign(this, { connection, model, clock });
  }

  /**
   * Send a goal. Its id is created here, so that a repeated request does not start a second goal.
   * @param {string} action Such as `navigate_to_pose`.
   * @param {object} goal Of the action's ROS type.
   * @returns {Promise<string>} Its id, after acceptance.
   */
  async sendGoal(robot, action, goal) {
    const bytes = crypto.getRandomValues(new Uint8Array(16));
    const id = Array.from(bytes, (byte) => byte.toString(16).padStart(2, '0')).join('');
    const answer = await this.connection.get(`${robot}/${action}/_action/send_goal`, { goal_id: id, goal });
    if (answer.accepted) return answer.goal_id;
    throw new Error(answer.error_msg || answer.reason || 'not accepted');
  }

  /** Send a robot to a point, with the final heading of a straight line from the robot. */
  goTo(robot, [x, y]) {
    const [x0, y0, before] = this.model.robots.get(robot)?.poseAt(this.clock.now()) ?? [x, y, 0];
    const facing = x === x0 && y === y0 ? before : Math.atan2(y - y0, x - x0);
    return this.sendGoal(robot, 'navigate_to_pose', { pose: poseStamped(x, y, facing) });
  }

  dock(robot, dock) {
    return this.sendGoal(robot, 'dock_robot', { use_dock_id: true, dock_id: dock, navigate_to_staging_pose: true });
  }

  undock(robot) { return this.sendGoal(robot, 'undock_robot', {}); }

  async cancel({ robot, action, id }) {
    const answer = await this.connection.get(`${robot}/${action}/_action/cancel_goal`, { goal_info: { goal_id: id } });
    if (answer.return_code !== 0) throw new Error('it has ended, or is canceling already');
  }

  async cancelAll(robot) {
    const goals = this.model.robots.get(robot)?.goals ?? [];
    if (!goals.length) throw new Error(`${robot} has no goal`);
    await Promise.all(goals.map((goal) => this.cancel(goal)));
  }

  pause() { return this.service('set_simulation_state', { state: { state: PAUSED } }); }

  resume() { return this.service('set_simulation_state', { state: { state: PLAYING } }); }

  /** Step while time is paused. */
  step(steps = 1) { return this.service('step_simulation', { steps }, STEP_TIMEOUT); }

  /** @param {number} factor Simulated seconds per wall second; 0 for as fast as possible. */
  setSpeed(factor) { return this.connection.get('_world/time/set', { real_time_factor: factor }); }

  /** Call a service of the world. */
  async service(name, request, timeout = 10) {
    const { result } = await this.connection.get(`_world/${name}`, request, { timeout });
    if (result?.result !== DONE) throw new Error(result?.error_message || `${name} failed, result ${result?.result}`);
  }
}
