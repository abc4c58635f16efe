// Requests of people at the page: sends them to the simulator, and reports success or failure.

import { ABORTED, ACCEPTED, isActive } from './model/goals.js';
import { actionWords, pointWords } from './model/phrases.js';

const LOOK = 50; // ms between two looks at a goal
// The number of looks to wait for the next stage of a goal. Looks are counted instead of time, as on a busy page a timer
// may fire before earlier messages are read. None is counted before simulated time has passed the goal's acceptance.
const PATIENCE = {
  sent: 600, // until an accepted goal is shown
  shown: 20, // until it begins, unless time stands
  begun: 6, // until a hopeless goal ends
};

export class Orders {
  constructor(app) {
    this.app = app;
  }

  /** Send a robot to a picked object: into a dock, or to the point. */
  send(robot, pick) {
    if (pick.kind === 'dock' && this.#robot(robot)?.actions.includes('dock_robot')) this.sendToDock(robot, pick.name);
    else this.sendToPoint(robot, pick);
  }

  /** Send a robot to a named object. */
  sendTo(robot, kind, name) {
    const point = this.app.pointOf(name, kind);
    if (point) this.send(robot, { kind, name, point });
  }

  /** Send a robot to the point of a picked object. */
  sendToPoint(robot, pick) {
    this.app.aim(null);
    const to = this.#nameOf(pick);
    this.#drive(`send ${robot} to ${to}`, () => this.app.commands.goTo(robot, pick.point), `${robot} is driving to ${to}.`);
  }

  /** Return the name of a picked object, or of the object at its point, or else the coordinates. */
  #nameOf({ kind, name, point }) {
    const { world } = this.app.model;
    if (kind === 'door') return `door ${name}`;
    return (['floor', 'lane'].includes(kind) ? world.nameAt(point) : name) || pointWords(point, world.units);
  }

  /** @param {string} [dock] By default the nearest free one. */
  sendToDock(robot, dock = this.#nearestDock(robot)) {
    this.app.aim(null);
    this.#drive(`dock ${robot} at ${dock}`, () => this.app.commands.dock(robot, dock), `${robot} is driving to ${dock}.`);
  }

  undock(robot) { this.#drive(`undock ${robot}`, () => this.app.commands.undock(robot), `${robot} is undocking.`); }

  cancelAll(robot) { this.ask(`cancel the goals of ${robot}`, () => this.app.commands.cancelAll(robot)); }

  /** Call a service of the world. @param {string} what The request, as after "Could not". */
  call(what, service, request) { this.ask(what, () => this.app.commands.service(service, request)); }

  /** Send a goal, and report whether it has begun. */
  #drive(what, send, done) { this.ask(what, async () => this.#begun(await send()), done); }

  /**
   * Open the form for a goal of any action that a robot serves.
   * @param {string} [chosen] The action to show first.
   * @param {Record<string, any>} [values] Initial values by dotted path.
   */
  fillInGoal(robot, chosen = 'navigate_to_pose', values = {}) {
    const { model, commands, toasts, form } = this.app;
    const serves = this.#robot(robot)?.actions ?? [];
    const forms = Object.fromEntries(Object.entries(model.forms.actions).filter(([name]) => serves.includes(name)));
    if (!Object.keys(forms).length) return toasts.show('error', `${robot} serves no actions`);
    const send = async (action, goal) => {
      await this.#begun(await commands.sendGoal(robot, action, goal).catch(pointToFields));
      toasts.show('good', `${robot}: ${forms[action].title} accepted.`);
    };
    return form.open({ title: `Send a goal to ${robot}`, label: 'Action', verb: 'Send', forms, chosen, values, robot, send });
  }

  /** Open the form for a fault. */
  fillInFault(target) {
    const [kind, name] = Object.entries(target)[0];
    const carries = this.#robot(target.robot)?.components ?? [];
    const forms = Object.fromEntries(Object.entries(this.app.model.forms.faults).filter(([, { subject, component }]) =>
      subject === kind && (component === undefined || carries.includes(component))));
    const send = (type, values) => this.#inject({ type, ...target, settings: JSON.stringify(values) }, target);
    const title = `Inject fault into ${kind === 'robot' ? '' : `${kind} `}${Array.isArray(name) ? name.join('–') : name}`;
    this.app.form.open({ title, label: 'Fault', verb: 'Inject', forms, robot: target.robot, send });
  }

  inject(fault) { this.ask(`inject ${actionWords(fault.type)}`, () => this.#inject(fault, fault)); }

  /** @param {object} fault Keys as in a world file: `{type: 'breakdown', robot: 'eve', duration: 20}`. */
  async #inject(fault, { robot, door, lane }) {
    await this.app.commands.service('inject_fault', fault).catch(pointToFields);
    this.app.toasts.show('good', `Injected ${actionWords(fault.type)} into ${robot ?? door ?? lane.join('–')}.`);
  }

  /** Wait until a goal has begun; throw the reason if it is aborted at once. */
  async #begun(id) {
    const known = () => this.app.model.goals.get(id);
    let [stage, looks] = ['', 0];
    for (let waited = 0; waited < PATIENCE.sent; waited += 1) {
      const before = stage;
      stage = stageOf(known());
      if (stage === 'ended') break;
      looks = stage !== before || this.#isFirstInstant(known()) ? 0 : looks + 1;
      if (looks >= PATIENCE[stage]) break;
      await new Promise((resolve) => setTimeout(resolve, LOOK));
    }
    if (known()?.status === ABORTED) throw new Error(known().errorMsg || `aborted, code ${known().errorCode}`);
  }

  /** Return whether simulated time still is at a goal's acceptance. */
  #isFirstInstant(goal) {
    const { factor, paused, received } = this.app.clock;
    return goal !== undefined && factor > 0 && !paused && received <= goal.accepted;
  }

  /**
   * Send a request, and report the result in a toast.
   * @param {string} what The request, as after "Could not".
   * @param {string} [done] The text upon success.
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

  #robot(name) { return this.app.model.robots.get(name); }

  #nearestDock(name) {
    const robot = this.#robot(name);
    const [x, y] = robot?.poseAt(this.app.now()) ?? [0, 0];
    const far = ({ at, docked, capacity }) => Math.hypot(at[0] - x, at[1] - y) + (docked.length < capacity ? 0 : 1e9);
    const suited = [...this.app.model.docks.values()].filter(({ reserved_for: only }) => !only || only.includes(name) || only.includes(robot?.type));
    return suited.sort((one, other) => far(one) - far(other))[0]?.name ?? '';
  }
}

function stageOf(goal) {
  if (goal === undefined) return 'sent';
  if (goal.status <= ACCEPTED) return 'shown';
  return isActive(goal.status) ? 'begun' : 'ended';
}

/** Rethrow an error with the names of the form's fields in its details. */
function pointToFields(error) {
  const said = error.details ?? error.message.split('; ').map((text) => text.match(/^([\w.]+): (.*)$/)).filter(Boolean)
    .map(([, field, message]) => ({ field, message }));
  error.details = said.map(({ field, message }) => ({ field: field.replace(/^goal\./, ''), message }));
  throw error;
}
