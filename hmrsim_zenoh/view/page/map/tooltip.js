/** A line beside the pointer that says what is below it. */

const STYLE = `position:absolute;left:0;top:0;z-index:2;pointer-events:none;max-width:260px;padding:4px 8px;
border-radius:6px;font:12px/1.35 system-ui,-apple-system,'Segoe UI',Roboto,sans-serif;white-space:pre-line;
box-shadow:0 2px 8px rgb(0 0 0/.25);visibility:hidden`;

export class Tooltip {
  /** @param {HTMLElement} element what it is within */
  constructor(element) {
    this.box = document.createElement('div');
    this.box.style.cssText = STYLE;
    this.box.setAttribute('role', 'tooltip');
    this.text = '';
    element.append(this.box);
  }

  /** @param {string} text "" hides it */
  show(text, px, py, width, colours) {
    if (text !== this.text) {
      this.text = text;
      this.box.textContent = text;
      this.box.style.visibility = text ? 'visible' : 'hidden';
      this.box.style.background = colours.ink;
      this.box.style.color = colours.background;
    }
    if (!text) return;
    const left = px > width * 0.65 ? px - 14 - this.box.offsetWidth : px + 14;
    this.box.style.transform = `translate(${Math.max(4, Math.round(left))}px, ${Math.round(py + 16)}px)`;
  }
}

/** Return what is to be said about what was picked; "" for what speaks for itself. */
export function sayOf({ kind, name }, { model, world }, time) {
  const thing = { robot: 'robots', item: 'items', dock: 'docks', door: 'doors', lift: 'lifts' }[kind];
  const now = thing && model[thing].get(name);
  switch (kind) {
    case 'robot': return now ? sayOfRobot(now, time) : '';
    case 'item': return `${name} · item${now?.weight ? `, ${now.weight} kg` : ''}`;
    case 'dock': return `${name} · ${now.type}, ${now.docked.length ? now.docked.join(', ') : 'free'}${queue(now)}`;
    case 'door': return `${name} · ${now.type === 'door' ? '' : `${now.type} `}door, ${doorState(now)}`;
    case 'lift': return `${name} · lift at ${now.stop}${now.to ? `, on its way to ${now.to}` : ''}`;
    case 'place': return `${name} · place`;
    case 'waypoint': return `${name} · waypoint`;
    case 'lane': return sayOfLane(world.lanesByKey.get(name), model);
    default: return '';
  }
}

function sayOfRobot(robot, time) {
  const state = robot.stateAt(time);
  const waits = robot.waits ? robot.waitsFor.join(', ') || robot.waitsWhy : '';
  const why = Object.values(robot.ailments).join('; ') || waits;
  const link = state === 'waiting' && robot.waitsFor.length ? 'for ' : '';
  const battery = robot.battery ? `\nbattery ${Math.round(robot.battery.percentage * 100)} %` : '';
  const goal = robot.goal ? `\n${robot.goal.action}` : '';
  return `${robot.name} · ${robot.type}, ${state}${why ? ` ${link}${why}` : ''}${goal}${battery}`;
}

function queue({ queue }) {
  return queue.length ? `; waiting: ${queue.join(', ')}` : '';
}

function doorState({ state, locked, jammed }) {
  return `${state}${locked ? ', locked' : ''}${jammed ? ', jammed' : ''}`;
}

function sayOfLane(lane, model) {
  if (!lane) return '';
  const why = model.closedLanes.get(lane.key) ?? model.closedLanes.get(`${lane.to}|${lane.from}`);
  const room = lane.capacity === null ? '' : `, for ${lane.capacity}`;
  const limit = lane.speed_limit === null ? '' : `, at most ${lane.speed_limit} a second`;
  const closed = why === undefined ? '' : `\nclosed${why ? `: ${why}` : ''}`;
  return `${lane.from} ${lane.one_way ? '→' : '↔'} ${lane.to}${room}${limit}${closed}`;
}
