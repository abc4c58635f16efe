// Robots by state and their batteries over time, on two small canvases.

import { STATES } from '../model/robot.js';
import { el, mark, say, sign } from './dom.js';
import { clockWords, shareWords } from './phrases.js';

const HEIGHT = 170;
const MARGIN = { left: 48, right: 8, top: 8, bottom: 22 };
const MOST_LINES = 8;
const TICKS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 36000, 86400];

export class ChartsPanel {
  /** @param {import('../app.js').App} app */
  constructor(app) {
    this.app = app;
    this.title = 'Charts';
    this.states = el('canvas', { class: 'chart', role: 'img' });
    this.batteries = el('canvas', { class: 'chart', role: 'img' });
    this.legend = el('ul', { class: 'legend-line' });
    this.lines = el('ul', { class: 'legend-line' });
    this.which = el('p', { class: 'note' });
    this.counts = new Map();
    for (const state of STATES) {
      const count = el('b');
      this.counts.set(state, count);
      this.legend.append(el('li', {}, sign('state', state), `${state} `, count));
    }
    this.element = el('div', { class: 'panel-body scroll charts' },
      el('h3', { text: 'Robots by state' }), this.states, this.legend,
      el('h3', { text: 'Batteries' }), this.which, this.batteries, this.lines);
  }

  render() {
    const { history } = this.app.model;
    const now = this.app.now();
    const from = Math.min(history.t[0] ?? now, now - 10);
    this.#drawStates(history, from, now);
    this.#drawBatteries(history, from, now);
  }

  #drawStates(history, from, now) {
    const { t, counts } = history;
    const robots = [...this.app.model.robots.values()];
    const current = new Map(STATES.map((state) => [state, 0]));
    for (const robot of robots) {
      const state = robot.stateAt(now);
      current.set(state, current.get(state) + 1);
    }
    for (const [state, count] of current) say(this.counts.get(state), String(count));
    mark(this.states, 'aria-label', `Robots by state over time; now ${[...current].map((pair) => pair.join(' ')).join(', ')}`);
    const most = Math.max(1, robots.length, ...t.map((_, i) => STATES.reduce((sum, s) => sum + counts[s][i], 0)));
    const chart = this.#begin(this.states, from, now, most, (value) => String(value));
    if (!chart) return;
    const times = [...t, now];
    const below = times.map(() => 0);
    for (const state of [...STATES].reverse()) {
      const values = [...counts[state], current.get(state)];
      chart.area(times, below, values, this.app.palette.states[state]);
    }
  }

  #drawBatteries(history, from, now) {
    const chosen = this.#chosen();
    const colours = this.app.palette.types;
    say(this.which, chosen.note);
    mark(this.batteries, 'aria-label', chosen.robots.map((r) => `${r.name} ${shareWords(r.battery.percentage)}`).join(', '));
    const chart = this.#begin(this.batteries, from, now, 1, (value) => `${Math.round(value * 100)} %`);
    const said = chosen.robots.map(({ name, battery }) => `${name} ${shareWords(battery.percentage)}`).join('|');
    if (said !== this.said) {
      this.said = said;
      this.lines.replaceChildren(...chosen.robots.map(({ name, battery }, i) => {
        const dash = el('span', { class: 'dash', 'aria-hidden': 'true' });
        dash.style.background = colours[i % colours.length];
        return el('li', {}, dash, el('button', {
          type: 'button', class: 'link', text: name, onclick: () => this.app.select(name, { center: true }),
        }), el('b', { text: ` ${shareWords(battery.percentage)}` }));
      }));
    }
    if (!chart) return;
    chosen.robots.forEach((robot, i) => {
      const points = [...(history.batteries.get(robot.name) ?? []), [now, robot.battery.percentage]];
      chart.line(points, colours[i % colours.length], robot.name === this.app.map.selected);
    });
  }

  /** Return whose batteries are shown: all, or where there are too many the selected robot's and the lowest. */
  #chosen() {
    const all = [...this.app.model.robots.values()].filter((robot) => robot.battery);
    if (all.length === 0) return { robots: [], note: 'No robot has a battery.' };
    if (all.length <= MOST_LINES) return { robots: all, note: '' };
    all.sort((a, b) => a.battery.percentage - b.battery.percentage);
    const selected = all.find((robot) => robot.name === this.app.map.selected);
    const lowest = all.filter((robot) => robot !== selected).slice(0, MOST_LINES - (selected ? 1 : 0));
    const who = `The ${lowest.length} lowest of ${all.length}`;
    return { robots: selected ? [selected, ...lowest] : lowest, note: selected ? `${selected.name}, and ${who.toLowerCase()}` : who };
  }

  #begin(canvas, from, to, most, words) {
    const width = canvas.clientWidth;
    if (width < 60) return null;
    const ratio = window.devicePixelRatio || 1;
    if (canvas.width !== Math.round(width * ratio)) {
      canvas.width = Math.round(width * ratio);
      canvas.height = Math.round(HEIGHT * ratio);
    }
    const pen = canvas.getContext('2d');
    pen.setTransform(ratio, 0, 0, ratio, 0, 0);
    pen.clearRect(0, 0, width, HEIGHT);
    return new Chart(pen, this.app.palette[this.app.theme.name], { width, from, to, most, words });
  }
}

class Chart {
  constructor(pen, colours, { width, from, to, most, words }) {
    this.pen = pen;
    this.from = from;
    this.to = to;
    this.most = most;
    this.right = width - MARGIN.right;
    this.bottom = HEIGHT - MARGIN.bottom;
    this.#axes(colours, words);
  }

  x(time) {
    return MARGIN.left + ((time - this.from) / Math.max(this.to - this.from, 1e-9)) * (this.right - MARGIN.left);
  }

  y(value) {
    return this.bottom - (value / this.most) * (this.bottom - MARGIN.top);
  }

  /** Lay values on what is below them, and add them to it. */
  area(times, below, values, colour) {
    const { pen } = this;
    if (values.every((value) => value === 0)) return;
    const tops = below.map((value, i) => value + values[i]);
    pen.beginPath();
    tops.forEach((value, i) => this.#corner(times, tops, i, i === 0));
    for (let i = below.length - 1; i >= 0; i -= 1) {
      pen.lineTo(this.x(times[i]), this.y(below[i]));
      if (i) pen.lineTo(this.x(times[i]), this.y(below[i - 1]));
    }
    pen.closePath();
    pen.fillStyle = colour;
    pen.globalAlpha = 0.85;
    pen.fill();
    pen.globalAlpha = 1;
    tops.forEach((value, i) => (below[i] = value));
  }

  line(points, colour, strong) {
    const { pen } = this;
    pen.beginPath();
    points.forEach(([time, value], i) => pen[i ? 'lineTo' : 'moveTo'](this.x(Math.max(time, this.from)), this.y(value)));
    pen.strokeStyle = colour;
    pen.lineWidth = strong ? 3.5 : 2;
    pen.lineJoin = 'round';
    pen.stroke();
  }

  /** A count stays what it is until the next one. */
  #corner(times, values, i, first) {
    if (first) this.pen.moveTo(this.x(times[0]), this.y(values[0]));
    else {
      this.pen.lineTo(this.x(times[i]), this.y(values[i - 1]));
      this.pen.lineTo(this.x(times[i]), this.y(values[i]));
    }
  }

  #axes(colours, words) {
    const { pen } = this;
    pen.font = '12px system-ui, sans-serif';
    pen.fillStyle = colours.muted;
    pen.strokeStyle = colours.line;
    pen.lineWidth = 1;
    pen.textAlign = 'right';
    pen.textBaseline = 'middle';
    for (const value of this.#values()) {
      const y = Math.round(this.y(value)) + 0.5;
      this.#stroke(MARGIN.left, y, this.right, y);
      pen.fillText(words(value), MARGIN.left - 6, y);
    }
    pen.textAlign = 'center';
    pen.textBaseline = 'top';
    const span = this.to - this.from;
    const tick = TICKS.find((each) => span / each <= 5) ?? TICKS[TICKS.length - 1];
    for (let time = Math.ceil(this.from / tick) * tick; time <= this.to; time += tick) {
      const x = Math.round(this.x(time)) + 0.5;
      this.#stroke(x, this.bottom, x, this.bottom + 4);
      if (x > MARGIN.left + 12 && x < this.right - 12) pen.fillText(clockWords(time), x, this.bottom + 7);
    }
  }

  #values() {
    if (this.most === 1) return [0, 0.25, 0.5, 0.75, 1];
    const raw = this.most / 4;
    const unit = 10 ** Math.floor(Math.log10(raw));
    const tick = Math.max(1, [1, 2, 5, 10].map((each) => each * unit).find((each) => each >= raw));
    const all = [];
    for (let value = 0; value <= this.most; value += tick) all.push(value);
    return all;
  }

  #stroke(x0, y0, x1, y1) {
    this.pen.beginPath();
    this.pen.moveTo(x0, y0);
    this.pen.lineTo(x1, y1);
    this.pen.stroke();
  }
}
