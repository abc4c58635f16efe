"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const STATES = ["offline", "stopped", "waiting", "driving", "charging", "busy", "idle"];
const SIGNS = { S: "✓", F: "✕", R: "▸", I: "·" };
const WORDS = { S: "success", F: "failure", R: "running", I: "not active" };
const SVG = "http://www.w3.org/2000/svg";
const NEAR = 12;
/** Milliseconds between two times at which the events are scrolled while the page plays. */
const FOLLOW = 300;

const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const find = (selector, within = document) => within.querySelector(selector);

function make(tag, attributes = {}, ...content) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) element.setAttribute(name, value);
  element.append(...content);
  return element;
}

function say(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** Return the number of values that are not greater than a limit; *key* returns the number of a value. */
function countUpTo(values, limit, key = (value) => value[0]) {
  let low = 0, high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (key(values[middle]) <= limit) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Return the last value with a time up to *at*, or undefined. */
const lastUpTo = (values, at) => values[countUpTo(values, at) - 1];

/** Return the span that contains a time, or undefined; without an end, it lasts. */
function spanAt(spans, at) {
  const span = lastUpTo(spans, at);
  return span && (span[1] === null || at < span[1]) ? span : undefined;
}

const seconds = (at) => `${at.toFixed(at < 1000 ? 3 : 1)} s`;

const stateOf = (robot, at) => STATES[spanAt(robot.states, at)?.[2] ?? 6];

/** Return the goals that a robot executes at a time, in words. */
const goalsOf = (robot, at) =>
  robot.goals.filter(([accepted, ended]) => accepted <= at && (ended === null || at < ended)).map(([, , text]) => text);

/** The poses of a robot, decoded from differences. */
class Poses {
  constructor(values) {
    this.frames = [];
    let frame = [0, 0, 0, 0];
    for (let i = 0; i < values.length; i += 4) {
      frame = frame.map((value, j) => value + values[i + j]);
      this.frames.push([frame[0] / 1000, frame[1] / 10, frame[2] / 10, frame[3]]);
    }
  }

  /** Return x, y and degrees at a time, in pixels of the map. */
  at(time) {
    const next = countUpTo(this.frames, time), a = this.frames[Math.max(0, next - 1)], b = this.frames[next];
    if (!b || next === 0) return a.slice(1);
    const share = (time - a[0]) / (b[0] - a[0]);
    return [1, 2, 3].map((i) => a[i] + (b[i] - a[i]) * share);
  }
}

/** One run: its map, table, tree and events. */
class Run {
  constructor(number, values) {
    this.values = values;
    this.number = number;
    const root = find(`.run[data-run="${number}"]`);
    const parts = (name) => new Map(all(`[data-${name}]`, root).map((each) => [each.dataset[name], each]));
    this.bodies = parts("robot");
    this.boxes = parts("item");
    this.doors = parts("door");
    this.lanes = parts("lane");
    this.waits = find("svg", root).appendChild(document.createElementNS(SVG, "g"));
    this.waits.setAttribute("class", "waits");
    this.robots = values.robots.map((robot) => ({ ...robot, track: new Poses(robot.poses) }));
    this.rows = this.robots.map((robot) => this.#row(robot));
    find(".now", root).append(...this.rows.map((row) => row.element));
    this.#listEvents(find(`.events[data-run="${number}"]`));
    this.tree = find(`.tree[data-run="${number}"]`);
    this.tick = find(`.tick[data-run="${number}"]`);
  }

  #row(robot) {
    const sign = make("i"), state = make("span"), goal = make("td"), holds = make("td"), battery = make("td", { class: "n" });
    const element = make("tr", {}, make("th", { scope: "row" }, robot.name), make("td", {}, sign, state), goal, holds, battery);
    return { element, sign, state, goal, holds, battery };
  }

  #listEvents(list) {
    this.list = list;
    const { lines, violations } = this.values;
    this.items = lines.map(([at, subject, text, severity], i) => {
      const item = make("li", { class: severity === "warning" ? "notice" : severity }, make("time", {}, at.toFixed(3)), make("span", {}, make("b", {}, subject), ` ${text}`));
      item.addEventListener("click", () => show(at, this.number, i + 1));
      return item;
    });
    this.lines = this.items.length;
    const first = data.difference?.lines[this.number];
    if (first !== undefined) this.items[first]?.classList.add("difference");
    this.list.append(...this.items);
    for (const [at, text] of violations) {
      const item = make("li", { class: "violated" }, make("time", {}, at.toFixed(3)), make("span", {}, `violated: ${text}`));
      item.addEventListener("click", () => show(at));
      const before = this.items[countUpTo(lines, at)];
      before ? before.before(item) : this.list.append(item);
    }
  }

  /** Show the run at a time, after a number of its events. */
  show(at, lines) {
    const carried = new Map(), places = new Map();
    this.robots.forEach((robot) => places.set(robot.name, robot.track.at(at)));
    for (const [name, values] of this.values.items) {
      const where = lastUpTo(values, at)?.[1];
      const box = this.boxes.get(name);
      const robot = typeof where === "string" ? places.get(where) : undefined;
      if (robot) carried.set(where, [...(carried.get(where) ?? []), name]);
      const point = robot ? [robot[0] + 5, robot[1] + 5] : where;
      box.toggleAttribute("hidden", !Array.isArray(point));
      if (Array.isArray(point)) box.setAttribute("transform", `translate(${point[0]} ${point[1]})`);
    }
    this.waits.replaceChildren();
    this.robots.forEach((robot, i) => this.#showRobot(robot, this.rows[i], places, at, carried.get(robot.name) ?? []));
    for (const [name, values] of this.values.doors) this.doors.get(name)?.classList.toggle("on", lastUpTo(values, at)?.[1] ?? false);
    for (const [name, values] of this.values.lanes) this.lanes.get(name)?.classList.toggle("on", lastUpTo(values, at)?.[1] ?? false);
    this.#showEvent(lines);
  }

  #showRobot(robot, row, places, at, holds) {
    const [x, y, yaw] = places.get(robot.name);
    const over = at >= this.values.end;
    const state = stateOf(robot, Math.min(at, this.values.end - 1e-6));
    const gone = lastUpTo(robot.gone, at)?.[1] ?? false;
    const body = this.bodies.get(robot.name);
    body.toggleAttribute("hidden", gone);
    body.setAttribute("transform", `translate(${x.toFixed(1)} ${y.toFixed(1)})`);
    find(".body", body).setAttribute("transform", `rotate(${Math.round(yaw)})`);
    body.dataset.state = state;
    const wait = spanAt(robot.waits, at);
    for (const other of wait?.[3] ?? []) {
      const to = places.get(other);
      if (!to) continue;
      const line = document.createElementNS(SVG, "line");
      Object.entries({ x1: x, y1: y, x2: to[0], y2: to[1] }).forEach(([name, value]) => line.setAttribute(name, value));
      this.waits.append(line);
    }
    row.element.hidden = gone;
    row.sign.className = state;
    say(row.state, over ? "the run is over" : state);
    say(row.goal, [...goalsOf(robot, at), ...(wait ? [this.#why(robot, at)] : [])].join("; ") || "–");
    say(row.holds, holds.join(", ") || "–");
    const charge = lastUpTo(robot.battery, at);
    say(row.battery, charge ? `${Math.round(100 * charge[1])} %` : "–");
  }

  /** Return why a robot waits at a time: the chain of robots up to one that does not wait. */
  #why(robot, at) {
    const texts = [], seen = new Set();
    for (let each = robot, wait; each; each = this.robots.find(({ name }) => name === wait[3][0])) {
      const who = texts.length ? `${each.name} ` : "";
      if (seen.has(each.name)) return [...texts, `${who}again: a circle`].join(" → ");
      seen.add(each.name);
      wait = spanAt(each.waits, at);
      if (!wait) return [...texts, `${who}${this.#activity(each, at)}`].join(" → ");
      const others = wait[3].length ? ` for ${wait[3].join(", ")}` : wait[2] ? "" : " for its turn";
      const what = `${others}${wait[2] ? `: ${wait[2]}` : ""}`;
      texts.push(`${who}waits since ${seconds(wait[0])}${what}`);
    }
    return texts.join(" → ");
  }

  #activity(robot, at) {
    const state = stateOf(robot, at), goals = goalsOf(robot, at).join(", ");
    return goals && state !== "stopped" ? `executes ${goals}` : `is ${state}`;
  }

  #showEvent(lines) {
    this.current?.classList.remove("now");
    this.current = this.items[lines - 1];
    this.current?.classList.add("now");
    const [first, last] = [Math.min(lines, this.lines), Math.max(lines, this.lines)];
    for (const item of this.items.slice(first, last)) item.classList.toggle("later", lines < this.lines);
    this.lines = lines;
    this.near?.forEach((each) => each.classList.remove("near"));
    this.near = this.items.slice(Math.max(0, lines - NEAR), lines + NEAR);
    this.near.forEach((each) => each.classList.add("near"));
  }

  /** Scroll to the last event that has happened, which lays the page out. */
  follow() {
    const item = this.current ?? this.items[0];
    if (item) this.list.scrollTop = item.offsetTop - this.list.clientHeight / 2;
  }

  /** Return the last tick of a robot's tree at a time, after a number of events; undefined if there is none. */
  tickOf(robot, at, lines) {
    const tree = this.values.trees.find((each) => each.robot === robot);
    if (!tree) return undefined;
    const [time, , shape, statuses, messages] = tree.ticks[Math.min(countUpTo(tree.ticks, at), countUpTo(tree.ticks, lines, (tick) => tick[1])) - 1] ?? [];
    if (time === undefined) return undefined;
    const texts = new Map();
    for (let i = 0; i < messages.length; i += 2) texts.set(messages[i], tree.texts[messages[i + 1]]);
    return { time, nodes: tree.shapes[shape].map(([depth, symbol, kind, name], i) => ({ depth, symbol, kind, name, is: statuses[i], message: texts.get(i) ?? "" })) };
  }

  showTree(tick, other) {
    const text = tick ? JSON.stringify([tick.nodes, other?.nodes.map((node) => node.is)]) : "";
    say(this.tick, tick ? `last changed at ${seconds(tick.time)}` : "not ticked yet");
    if (text === this.treeShown) return;
    this.treeShown = text;
    const same = other && tick && other.nodes.length === tick.nodes.length;
    this.tree.replaceChildren(...(tick?.nodes ?? []).map(({ depth, symbol, kind, name, is, message }, i) => {
      const differs = same && other.nodes[i].is !== is;
      const item = make("li", { "data-is": is, title: `${kind}, ${WORDS[is]}`, class: differs ? "differs" : "" },
        make("b", { "aria-label": WORDS[is] }, SIGNS[is] ?? is), make("span", { class: "symbol" }, `${symbol} `), name,
        make("span", { class: "message" }, message ? ` – ${message}` : ""));
      item.style.setProperty("--depth", depth);
      return item;
    }));
    const running = all("[data-is=R]", this.tree), item = find(".differs", this.tree) ?? running[running.length - 1];
    if (item) this.tree.scrollTop = item.offsetTop - this.tree.clientHeight / 3;
  }
}

const runs = data.runs.map((values, number) => new Run(number, values));
const slider = find("#time"), clock = find("#clock"), chart = find(".chart"), line = find(".cursor"), treeOf = find("#tree");
let playing = 0, before = 0, followed = 0;
const cursor = { at: 0, lines: runs.map(() => 0), ticked: runs.map(() => 0) };

/** Return how many events of each run have happened at a time, or after the *count*-th event of run *number*. */
function linesAt(at, number, count) {
  return runs.map((run, i) => {
    if (number === undefined) return countUpTo(run.values.lines, at);
    if (i === number) return count;
    const happened = countUpTo(run.values.lines, at), seen = data.difference?.seen;
    if (!seen || count > seen[number]) return happened;
    return count === seen[number] ? seen[i] : Math.min(happened, data.difference.lines[i]);
  });
}

/** Show a time; with the number of a run and a count, the moment after so many of its events. */
function show(at, number, count) {
  cursor.at = Math.min(data.length, Math.max(0, at));
  cursor.lines = cursor.ticked = linesAt(cursor.at, number, count);
  slider.value = cursor.at;
  const text = seconds(cursor.at);
  slider.setAttribute("aria-valuetext", text);
  say(clock, `${text} of ${seconds(data.length)}`);
  // One element moves, as a property of the chart would restyle all of its bars.
  line.style.left = `calc(var(--names) + (100% - var(--names)) * ${cursor.at / data.length})`;
  runs.forEach((run, i) => run.show(cursor.at, cursor.lines[i]));
  showTrees();
  if (playing && performance.now() < followed + FOLLOW) return;
  followed = performance.now();
  runs.forEach((run) => run.follow());
}

function showTrees() {
  if (!treeOf) return;
  const ticks = runs.map((run, i) => run.tickOf(treeOf.value, cursor.at, cursor.ticked[i]));
  runs.forEach((run, i) => run.showTree(ticks[i], ticks[1 - i]));
}

/** Step to the next event of the first run, or to the previous one. */
function step(by) {
  const { lines } = runs[0].values, count = Math.min(lines.length, Math.max(0, cursor.lines[0] + by));
  pause();
  show(count ? lines[count - 1][0] : 0, 0, count);
}

function showDifference() {
  if (!data.difference) return;
  pause();
  show(data.difference.at, 0, data.difference.seen[0]);
  // The trees react to the event after it, at the same instant.
  cursor.ticked = linesAt(cursor.at);
  showTrees();
}

const play = find("#play"), speed = find("#speed");

function pause() {
  cancelAnimationFrame(playing);
  playing = 0;
  say(play, "▶");
  play.setAttribute("aria-pressed", "false");
}

function frame(now) {
  show(cursor.at + ((now - before) / 1000) * Number(speed.value));
  before = now;
  if (cursor.at < data.length) playing = requestAnimationFrame(frame);
  else pause();
}

function toggle() {
  if (playing) return pause();
  if (cursor.at >= data.length) show(0);
  before = performance.now();
  playing = requestAnimationFrame(frame);
  say(play, "⏸");
  return play.setAttribute("aria-pressed", "true");
}

play.addEventListener("click", toggle);
find("#previous").addEventListener("click", () => step(-1));
find("#next").addEventListener("click", () => step(1));
find("#difference")?.addEventListener("click", showDifference);
slider.addEventListener("input", () => { pause(); show(Number(slider.value)); });
slider.addEventListener("keydown", (event) => {
  const unit = data.length < 60 ? 0.1 : 1;
  const by = { ArrowRight: unit, ArrowUp: unit, ArrowLeft: -unit, ArrowDown: -unit, PageUp: 10 * unit, PageDown: -10 * unit }[event.key];
  if (by === undefined) return;
  event.preventDefault();
  pause();
  show(cursor.at + by * (event.shiftKey ? 10 : 1));
});
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey || ["SELECT", "BUTTON", "SUMMARY"].includes(event.target.tagName)) return;
  const act = { " ": toggle, n: () => step(1), p: () => step(-1), d: showDifference }[event.key];
  if (!act) return;
  event.preventDefault();
  act();
});
for (const button of all(".jump")) {
  button.addEventListener("click", () => {
    const { at, seen } = button.dataset;
    pause();
    if (seen === undefined) show(Number(at));
    else show(Number(at), 0, Number(seen));
  });
}
chart.addEventListener("click", (event) => {
  const track = event.target.closest(".track");
  if (!track) return;
  const { left, width } = track.getBoundingClientRect();
  pause();
  show(((event.clientX - left) / width) * data.length);
});
if (treeOf) {
  const robots = [...new Set(data.runs.flatMap((run) => run.trees.map((tree) => tree.robot)))];
  const first = data.runs[0].lines[data.difference?.lines[0] ?? -1]?.[1];
  treeOf.append(...robots.map((robot) => make("option", {}, robot)));
  if (robots.includes(first)) treeOf.value = first;
  treeOf.hidden = robots.length < 2;
  treeOf.addEventListener("change", showTrees);
}
line.style.height = `${chart.scrollHeight}px`;
speed.value = ["1", "2", "5", "20", "100"].find((each) => data.length / Number(each) <= 40) ?? "100";
if (data.difference) showDifference();
else show(data.at);
document.documentElement.dataset.ready = "true";
