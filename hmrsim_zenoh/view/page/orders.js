// What is asked of the simulator for the people at the page, and what is said of how that went.

import { ABORTED, ACCEPTED, isActive } from './model/goals.js';
import { actionWords } from './panels/phrases.js';

const LOOK = 50; // ms from one look at a goal to the next
// How many looks the next stage of a goal is waited for. Looks are counted, as on a busy page a timer may be due before
// what had come earlier is read; and none is counted before simulated time has passed the goal's first instant.
const PATIENCE = {
  sent: 600, // until one that was accepted is shown
  shown: 20, // until it begins, unless time stands still
  begun: 6, // until one that is hopeless ends
};

export class Orders {
  constructor(app, patience = PATIENCE) {
    this.app = app;
    this.patience = patience;
  }

  /** Send a robot to what was picked: into a dock, or to the point. */
  send(robot, pick) {
    if (pick.kind === 'dock' && this.#may(robot, 'dock_robot')) this.sendToDock(robot, pick.name);
    else this.sendToPoint(robot, pick);
  }

  /** Send a robot to what has a name. */
  sendTo(robot, kind, name) {
    const point = this.app.pointOf(name, kind);
    if (point) this.send(robot, { kind, name, point });
  }

  /** Send a robot to where something is that was picked. */
  sendToPoint(robot, pick) {
    this.app.aim(null);
    const name = ['floor', 'lane', 'door'].includes(pick.kind) ? '' : pick.name;
    const to = name || pick.point.map((each) => each.toFixed(this.app.model.world.units === 'px' ? 0 : 1)).join(', ');
    this.ask(`send ${robot} to ${to}`, async () => this.#begun(await this.app.commands.goTo(robot, pick.point)), `${robot} is driving to ${to}.`);
  }

  /** @param {string} [dock] Left out: the nearest that is free. */
  sendToDock(robot, dock = this.#nearestDock(robot)) {
    this.app.aim(null);
    this.ask(`dock ${robot} at ${dock}`, async () => this.#begun(await this.app.commands.dock(robot, dock)), `${robot} is driving to ${dock}.`);
  }

  undock(robot) {
    this.ask(`undock ${robot}`, async () => this.#begun(await this.app.commands.undock(robot)), `${robot} is undocking.`);
  }

  /**
   * Have a goal be filled in, of any action that a robot serves.
   * @param {string} [chosen] The action that comes first.
   * @param {Record<string, any>} [values] What is filled in already, by dotted path.
   */
  fillInGoal(robot, chosen = 'navigate_to_pose', values = {}) {
    const { actions } = this.app.model.forms;
    const serves = this.app.model.robots.get(robot)?.actions ?? [];
    const forms = Object.fromEntries(Object.entries(actions).filter(([name]) => serves.includes(name)));
    if (!Object.keys(forms).length) return this.app.toasts.show('error', `${robot} serves no actions`);
    const send = async (action, goal) => {
      await this.#begun(await this.app.commands.sendGoal(robot, action, goal).catch(pointToFields));
      this.app.toasts.show('good', `${robot}: ${forms[action].title} accepted.`);
    };
    return this.app.form.open({ title: `Send a goal to ${robot}`, label: 'Action', verb: 'Send', forms, chosen, values, robot, send });
  }

  /** Have a fault be filled in. */
  fillInFault(target) {
    const [kind, name] = Object.entries(target)[0];
    const carries = this.app.model.robots.get(target.robot)?.components ?? [];
    const forms = Object.fromEntries(Object.entries(this.app.model.forms.faults).filter(([, { subject, component }]) =>
      subject === kind && (component === undefined || carries.includes(component))));
    const send = (type, values) => this.#inject({ type, ...target, settings: JSON.stringify(values) }, target);
    const title = `Inject fault into ${kind === 'robot' ? '' : `${kind} `}${Array.isArray(name) ? name.join('–') : name}`;
    this.app.form.open({ title, label: 'Fault', verb: 'Inject', forms, robot: target.robot, send });
  }

  inject(fault) {
    this.ask(`inject ${actionWords(fault.type)}`, () => this.#inject(fault, fault));
  }

  async #inject(fault, { robot, door, lane }) {
    await this.app.commands.injectFault(fault).catch(pointToFields);
    this.app.toasts.show('good', `Injected ${actionWords(fault.type)} into ${robot ?? door ?? lane.join('–')}.`);
  }

  /** Return when a goal has begun; throw why it was aborted at once. */
  async #begun(id) {
    const { model } = this.app;
    const known = () => model.goals.get(id);
    let [stage, looks] = ['', 0];
    for (let waited = 0; waited < this.patience.sent; waited += 1) {
      const before = stage;
      stage = stageOf(known());
      if (stage === 'ended') break;
      looks = stage !== before || this.#isFirstInstant(known()) ? 0 : looks + 1;
      if (looks >= this.patience[stage]) break;
      await new Promise((resolve) => setTimeout(resolve, LOOK));
    }
    if (known()?.status === ABORTED) throw new Error(known().errorMsg || `aborted, code ${known().errorCode}`);
  }

  /** Return whether more may come of the instant in which a goal was accepted. */
  #isFirstInstant(goal) {
    const { factor, paused, received } = this.app.clock;
    return goal !== undefined && factor > 0 && !paused && received <= goal.accepted;
  }

  /**
   * Ask for something, and tell what came of it.
   * @param {string} what As after "could not".
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

function stageOf(goal) {
  if (goal === undefined) return 'sent';
  if (goal.status <= ACCEPTED) return 'shown';
  return isActive(goal.status) ? 'begun' : 'ended';
}

/** Throw an error again, with the names of the form's fields in its details. */
function pointToFields(error) {
  const said = error.details ?? error.message.split('; ').map((text) => text.match(/^([\w.]+): (.*)$/)).filter(Boolean)
    .map(([, field, message]) => ({ field, message }));
  error.details = said.map(({ field, message }) => ({ field: field.replace(/^goal\./, ''), message }));
  throw error;
}
