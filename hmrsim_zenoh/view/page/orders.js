// What is asked of the simulator for whoever looks at the page, and what is said of how that went.

export class Orders {
  /** @param {import('./app.js').App} app */
  constructor(app) {
    this.app = app;
  }

  /** Send a robot to what was picked: into a dock, or to the point. */
  send(robot, pick) {
    if (pick.kind === 'dock' && this.#may(robot, 'dock_robot')) this.sendToDock(robot, pick.name);
    else this.sendToPoint(robot, pick);
  }

  /** Send a robot to what has a name. */
  sendTo(robot, kind, name) {
    const point = this.app.pointOf(name);
    if (point) this.send(robot, { kind, name, point });
  }

  /** Send a robot to where something is that was picked. */
  sendToPoint(robot, pick) {
    this.app.aim(null);
    const name = ['floor', 'lane', 'door'].includes(pick.kind) ? '' : pick.name;
    const to = name || pick.point.map((each) => each.toFixed(this.app.model.world.units === 'px' ? 0 : 1)).join(', ');
    this.ask(`send ${robot} to ${to}`, () => this.app.commands.goTo(robot, pick.point), `${robot} is on its way to ${to}.`);
  }

  /** @param {string} robot @param {string} [dock] Left out: the nearest that is free. */
  sendToDock(robot, dock = this.#nearestDock(robot)) {
    this.app.aim(null);
    this.ask(`dock ${robot} at ${dock}`, () => this.app.commands.dock(robot, dock), `${robot} is on its way to ${dock}.`);
  }

  inject(fault) {
    const what = `${fault.type.replaceAll('_', ' ')} (${fault.robot ?? fault.door ?? fault.lane.join(' – ')})`;
    this.ask(`inject ${what}`, () => this.app.commands.injectFault(fault), `Injected: ${what}.`);
  }

  /**
   * Ask for something, and tell what came of it.
   * @param {string} what As after "could not".
   * @param {() => Promise<any>} request
   * @param {string} [done] What to say when it went well.
   */
  async ask(what, request, done = '') {
    try {
      await request();
      if (done) this.app.toasts.show('good', done);
    } catch (error) {
      const details = (error.details ?? []).map(({ field, message }) => `${field}: ${message}`);
      this.app.toasts.show('error', `Could not ${what}`, [error.message, ...details].join('; '));
    }
  }

  #may(robot, action) {
    return this.app.model.robots.get(robot)?.actions.includes(action) ?? false;
  }

  #nearestDock(name) {
    const [x, y] = this.app.model.robots.get(name)?.poseAt(this.app.now()) ?? [0, 0];
    const far = ({ at, docked, capacity }) => Math.hypot(at[0] - x, at[1] - y) + (docked.length < capacity ? 0 : 1e9);
    const suited = [...this.app.model.docks.values()].filter(({ reserved_for: only }) =>
      !only || only.includes(name) || only.includes(this.app.model.robots.get(name)?.type));
    return suited.reduce((best, dock) => (best === null || far(dock) < far(best) ? dock : best), null)?.name ?? '';
  }
}
