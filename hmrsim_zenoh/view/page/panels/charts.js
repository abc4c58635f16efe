// Robots by state, their batteries and chosen numbers over time, drawn by uPlot.

import { STATES, countStates } from '../model/robot.js';
import { dash, el, mark, say, sign } from './dom.js';
import { clockWords, numberWords, shareWords } from '../model/phrases.js';
import { Plots } from './plots.js';
import uPlot from '../vendor/uplot/uPlot.esm.js';

const HEIGHT = 180; // css pixels
const MAX_LINES = 8;
const BETWEEN = 450; // ms from one drawing to the next, as each takes longer than a frame with many robots
const TICKS = [1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14400, 36000, 86400];
/** From the bottom of the stack to its top. */
const STACK = [...STATES].reverse();

export class ChartsPanel {
  constructor(app) {
    this.app = app;
    this.title = 'Charts';
    [this.states, this.batteries] = [0, 1].map(() => el('div', { class: 'chart', role: 'img' }));
    this.legend = el('ul', { class: 'legend-line' });
    this.lines = el('ul', { class: 'legend-line' });
    this.note = el('p', { class: 'note' });
    this.counts = new Map(STATES.map((state) => [state, el('b')]));
    for (const [state, count] of this.counts) this.legend.append(el('li', {}, sign('state', state), `${state} `, count));
    this.topics = new Plots(app);
    this.element = el('div', { class: 'panel-body scroll charts' },
      el('h3', { text: 'Robots by state' }), this.states, this.legend,
      el('h3', { text: 'Batteries' }), this.note, this.batteries, this.lines, this.topics.element);
    this.plots = new Map(); // the plots and their parameters by element
    this.next = 0;
  }

  /** @param {boolean} seen Whether the panel is open. */
  seen(seen) {
    this.next = 0;
    this.topics.seen(seen);
  }

  render() {
    const wall = performance.now();
    if (wall < this.next) return;
    this.next = wall + BETWEEN;
    const now = this.app.now();
    this.#drawStates(now);
    this.#drawBatteries(now);
    for (const plot of this.topics.all) this.#drawTopic(plot, now);
    for (const [element, { plot }] of this.plots) if (!element.isConnected) plot.destroy(), this.plots.delete(element);
  }

  #drawStates(now) {
    const { history, robots } = this.app.model;
    const current = countStates(robots, now);
    for (const [state, count] of this.counts) say(count, current[state]);
    mark(this.states, 'aria-label', `Robots by state over time; now ${STATES.map((state) => `${state} ${current[state]}`).join(', ')}`);
    const points = [...history.counts.points, [now, current]];
    const sums = new Array(points.length).fill(0);
    const stacked = STACK.map((state) => points.map(([, counts], i) => (sums[i] += counts[state])));
    const { states } = this.app.palette;
    // The highest first, as each covers the lower part of the previous one.
    const series = STACK.map((state) => ({ fill: states[state], width: 0, points: { show: false }, paths: uPlot.paths.stepped({ align: 1 }) })).reverse();
    this.#show(this.states, [points.map(([time]) => time), ...stacked.reverse()], series, { max: Math.max(1, ...sums), words: String, incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500] });
  }

  #drawBatteries(now) {
    const { robots, note } = this.#chosen();
    say(this.note, note);
    const lines = robots.map(({ name, battery }) => {
      return { name, points: [...(this.app.model.history.batteries.get(name)?.points ?? []), [now, battery.percentage]] };
    });
    this.#drawLines(this.batteries, this.lines, lines, now, { max: 1, words: shareWords, incrs: [0.25, 0.5] });
  }

  #drawTopic({ lines: all, chart, legend }, now) {
    const lines = Array.from(all, ([name, { points }]) => {
      const past = points.filter(([time]) => time <= now);
      return { name, points: past.length ? [...past, [now, past.at(-1)[1]]] : [] };
    }).filter(({ points }) => points.length);
    const values = lines.flatMap(({ points }) => points.map(([, value]) => value));
    const [least, most] = values.length ? [Math.min(...values), Math.max(...values)] : [0, 1];
    const margin = values.length && ((most - least) * 0.05 || Math.abs(most) * 0.05 || 1);
    this.#drawLines(chart, legend, lines, now, { min: least - margin, max: most + margin, words: numberWords });
  }

  /** Draw a line for each robot, and a legend with the last values. */
  #drawLines(chart, legend, lines, now, { words, ...scale }) {
    const colors = this.app.palette.types;
    const lasts = lines.map(({ name, points }) => `${name} ${words(points.at(-1)[1])}`.trim());
    mark(chart, 'aria-label', lasts.join(', '));
    if (legend.dataset.lines !== lasts.join('|')) {
      legend.dataset.lines = lasts.join('|');
      legend.replaceChildren(...lines.map(({ name, points }, i) => {
        const link = name && el('button', { type: 'button', class: 'link', text: name, onclick: () => this.app.select(name, { center: true }) });
        return el('li', {}, dash(colors[i]), link, el('b', { text: ` ${words(points.at(-1)[1])}` }));
      }));
    }
    const tables = lines.map(({ points }) => [points.map(([time]) => time), points.map(([, value]) => value)]);
    const { selected } = this.app.map;
    const series = lines.map(({ name }, i) => ({ stroke: colors[i], width: name === selected ? 3.5 : 2, spanGaps: true, points: { show: false } }));
    this.#show(chart, tables.length ? uPlot.join(tables) : [[now]], series, { words, ...scale });
  }

  /** Return the robots whose batteries are shown: all, or the selected one and those with the lowest charge. */
  #chosen() {
    const all = [...this.app.model.robots.values()].filter((robot) => robot.battery);
    if (all.length === 0) return { robots: [], note: 'No robot has a battery.' };
    if (all.length <= MAX_LINES) return { robots: all, note: '' };
    all.sort((a, b) => a.battery.percentage - b.battery.percentage);
    const selected = all.filter((robot) => robot.name === this.app.map.selected);
    const lowest = all.filter((robot) => !selected.includes(robot)).slice(0, MAX_LINES - selected.length);
    const who = `the ${lowest.length} lowest of ${all.length}`;
    return { robots: [...selected, ...lowest], note: selected.length ? `${selected[0].name} and ${who}` : who };
  }

  /** Draw a plot; it is created again if its lines, size or theme have changed. */
  #show(element, data, series, { min = 0, max, words, incrs }) {
    const width = element.clientWidth;
    if (width < 60) return;
    const { theme, palette } = this.app;
    const made = JSON.stringify([width, theme.name, series]);
    const known = this.plots.get(element);
    const [first, now] = [data[0][0], data[0].at(-1)];
    const scales = { x: { min: Math.min(first, now - 10), max: now }, y: { min, max } };
    if (known?.made === made) {
      known.plot.setData(data, false);
      known.plot.batch(() => Object.entries(scales).forEach(([scale, range]) => known.plot.setScale(scale, range)));
      return;
    }
    known?.plot.destroy();
    const { muted: stroke, line } = palette[theme.name];
    const axis = (more) => ({ stroke, ticks: { stroke: line, width: 1, size: 4 }, font: '12px system-ui, sans-serif', ...more });
    const plot = new uPlot({
      width, height: HEIGHT, legend: { show: false }, cursor: { show: false }, select: { show: false },
      scales: { x: { time: false, auto: false, ...scales.x }, y: { auto: false, ...scales.y } },
      axes: [
        axis({ incrs: TICKS, space: 64, size: 28, grid: { show: false }, values: (_, times) => times.map((time) => clockWords(time)) }),
        axis({ incrs, size: 50, grid: { stroke: line, width: 1 }, values: (_, values) => values.map(words) }),
      ],
      series: [{}, ...series],
    }, data, element);
    this.plots.set(element, { plot, made });
  }
}
