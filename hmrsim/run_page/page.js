"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const SIGNS = { S: "✓", F: "✕", R: "▸", I: "·" };
const WORDS = { S: "success", F: "failure", R: "running", I: "not active" };
const SVG = "http://www.w3.org/2000/svg";
const NEAR = 12;
/** Seconds within which times are the same. */
const INSTANT = 1e-7;
/** Pixels of the map between a point and an item there, and between two items. */
const BELOW = 9, STACKED = 11;
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

/** Return the last value that holds at a moment: a time, and a number of events up to then. */
const lastAt = (values, { at, lines }) => values[Math.min(countUpTo(values, at), countUpTo(values, lines, (value) => value[1])) - 1];

/** Return the span that contains a time, or undefined. */
function spanAt(spans, at) {
  const span = spans[countUpTo(spans, at) - 1];
  return span && at < span[1] ? span : undefined;
}

const seconds = (at) => `${at.toFixed(at < 1000 ? 3 : 1)} s`;

/** Return what the last change set that holds at a moment. */
const valueAt = (changes, moment, otherwise) => lastAt(changes, moment)?.[2] ?? otherwise;

const stateOf = (robot, moment) => valueAt(robot.state, moment, "idle");

/** Return the goals that a robot executes at a moment, in words. */
const goalsOf = (robot, moment) => valueAt(robot.goals, moment, []);

/** The poses of a robot, decoded from differences. */
class Poses {
  constructor(values) {
    this.frames = [];
    let frame = [0, 0, 0, 0];
    for (let i = 0; i < values.length; i += 4) {
      frame = frame.map((value, j) => value + values[i + j]);
      this.frames.push([frame[0] / 1e6, frame[1] / 10, frame[2] / 10, frame[3]]);
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
    this.printed = find(`.shown[data-run="${number}"]`);
    this.tick = find(`.tick[data-run="${number}"]`);
  }

  #row(robot) {
    const sign = make("i"), state = make("span"), goal = make("td"), holds = make("td"), battery = make("td", { class: "n" });
    const element = make("tr", {}, make("th", { scope: "row" }, robot.name), make("td", {}, sign, state), goal, holds, battery);
    return { element, sign, state, goal, holds, battery };
  }

  /** List the events and violations in order; each has the number of events up to it, and whether runs are compared by it. */
  #listEvents(list) {
    this.list = list;
    const { lines, violations, apart } = this.values, alone = new Set(apart);
    this.items = lines.map(([at, subject, text, severity], i) => ({ at, lines: i + 1, compared: !alone.has(i), kind: severity === "warning" ? "notice" : severity, text: [make("b", {}, subject), ` ${text}`] }));
    violations.forEach(([at, text], violation) => {
      const next = countUpTo(this.items, at, (item) => item.at);
      this.items.splice(next, 0, { at, lines: this.items[next - 1]?.lines ?? 0, compared: false, kind: "violated", text: [`violated: ${text}`], violation });
    });
    this.items.forEach((item, i) => {
      item.element = make("li", { class: item.kind }, make("time", {}, item.at.toFixed(3)), make("span", {}, ...item.text));
      item.element.addEventListener("click", () => showItem(this.number, i + 1));
    });
    this.shown = this.items.length;
    const first = data.difference?.lines[this.number];
    if (first !== undefined) this.items[this.itemsUpTo(first)]?.element.classList.add("difference");
    this.list.append(...this.items.map((item) => item.element));
  }

  /** Return the number of items up to the event with a number. */
  itemsUpTo(lines) {
    return lines ? this.items.findIndex((item) => item.lines === lines) + 1 : 0;
  }

  /** Show the run at a time, after a number of its items. */
  show(at, count) {
    const moment = { at, lines: this.items[count - 1]?.lines ?? 0 };
    // Waits have no number of an event: until the last item of an instant, those before it hold.
    this.inside = this.items[count]?.at <= at ? INSTANT : 0;
    const carried = new Map(), places = new Map(), lying = new Map();
    this.robots.forEach((robot) => places.set(robot.name, robot.track.at(at)));
    for (const [name, values] of Object.entries(this.values.items)) {
      const where = valueAt(values, moment);
      const box = this.boxes.get(name);
      const robot = typeof where === "string" ? places.get(where) : undefined;
      const beside = robot ? carried : lying, key = String(where), others = beside.get(key) ?? [];
      beside.set(key, [...others, name]);
      const point = robot ?? where;
      box.toggleAttribute("hidden", !Array.isArray(point));
      // Below the point, so that a robot there does not cover it.
      const below = (robot ? find(".ring", this.bodies.get(where)).r.baseVal.value : BELOW) + STACKED * others.length;
      if (Array.isArray(point)) box.setAttribute("transform", `translate(${point[0]} ${point[1] + below})`);
    }
    this.waits.replaceChildren();
    this.robots.forEach((robot, i) => this.#showRobot(robot, this.rows[i], places, moment, carried.get(robot.name) ?? []));
    for (const [kind, elements] of [["doors", this.doors], ["lanes", this.lanes]]) {
      for (const [name, values] of Object.entries(this.values[kind])) elements.get(name)?.classList.toggle("on", valueAt(values, moment, false));
    }
    this.#showItem(count);
  }

  #showRobot(robot, row, places, moment, holds) {
    const [x, y, yaw] = places.get(robot.name), at = moment.at - this.inside;
    const state = stateOf(robot, moment);
    const gone = valueAt(robot.gone, moment, true);
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
    const over = at > this.values.end;
    row.sign.className = over ? "" : state;
    say(row.state, over ? "ended" : state);
    say(row.goal, [...goalsOf(robot, moment), ...(wait ? [this.#why(robot, moment)] : [])].join("; ") || "–");
    say(row.holds, holds.join(", ") || "–");
    const charge = robot.battery[countUpTo(robot.battery, moment.at) - 1];
    say(row.battery, charge ? `${Math.round(100 * charge[1])} %` : "–");
  }

  /** Return why a robot waits at a time: the chain of robots up to one that does not wait. */
  #why(robot, moment) {
    const at = moment.at - this.inside, texts = [], seen = new Set();
    for (let each = robot, wait; each; each = this.robots.find(({ name }) => name === wait[3][0])) {
      const who = texts.length ? `${each.name} ` : "";
      if (seen.has(each.name)) return [...texts, `${who}again: a circle`].join(" → ");
      seen.add(each.name);
      wait = spanAt(each.waits, at);
      if (!wait) return [...texts, `${who}${this.#activity(each, moment)}`].join(" → ");
      const others = wait[3].length ? ` for ${wait[3].join(", ")}` : wait[2] ? "" : " for its turn";
      const what = `${others}${wait[2] ? `: ${wait[2]}` : ""}`;
      texts.push(`${who}waits since ${seconds(wait[0])}${what}`);
    }
    return texts.join(" → ");
  }

  #activity(robot, moment) {
    const state = stateOf(robot, moment), goals = goalsOf(robot, moment).join(", ");
    return goals && state !== "stopped" ? `executes ${goals}` : `is ${state}`;
  }

  #showItem(count) {
    this.current?.classList.remove("now");
    this.current = this.items[count - 1]?.element;
    this.current?.classList.add("now");
    const changed = this.items.slice(Math.min(count, this.shown), Math.max(count, this.shown));
    for (const item of changed) item.element.classList.toggle("later", count < this.shown);
    this.shown = count;
    this.near?.forEach((each) => each.element.classList.remove("near"));
    this.near = this.items.slice(Math.max(0, count - NEAR), count + NEAR);
    this.near.forEach((each) => each.element.classList.add("near"));
    const first = Math.max(1, count - NEAR + 1);
    say(this.printed, `events ${first} to ${first + this.near.length - 1} of ${this.items.length}, around ${seconds(cursor.at)}`);
  }

  /** Scroll to the last event that has happened, which lays the page out. */
  follow() {
    const item = this.current ?? this.items[0]?.element;
    if (item) this.list.scrollTop = item.offsetTop - this.list.clientHeight / 2;
  }

  /** Return the last tick of a robot's tree at a time, after a number of items; undefined if there is none. */
  tickOf(robot, at, count) {
    const tree = this.values.trees.find((each) => each.robot === robot);
    if (!tree) return undefined;
    const [time, , shape, statuses, messages] = lastAt(tree.ticks, { at, lines: this.#settled(count) }) ?? [];
    if (time === undefined) return undefined;
    const texts = new Map();
    for (let i = 0; i < messages.length; i += 2) texts.set(messages[i], tree.texts[messages[i + 1]]);
    return { time, nodes: tree.shapes[shape].map(([depth, kind, name, ports], i) => ({ depth, kind, name, ports, is: statuses[i], message: texts.get(i) ?? "" })) };
  }

  /** Return the number of events up to the next one by which runs are compared: a tree reacts after the fault and its like. */
  #settled(count) {
    while (this.items[count] && !this.items[count].compared) count += 1;
    return this.items[count - 1]?.lines ?? 0;
  }

  showTree(tick, other) {
    const text = tick ? JSON.stringify([tick.nodes, other?.nodes.map((node) => node.is)]) : "";
    say(this.tick, tick ? `last changed by the tick at ${seconds(tick.time)}` : "not ticked yet");
    if (text === this.treeShown) return;
    this.treeShown = text;
    const same = other && tick && other.nodes.length === tick.nodes.length;
    this.tree.replaceChildren(...(tick?.nodes ?? []).map(({ depth, kind, name, ports, is, message }, i) => {
      const differs = same && other.nodes[i].is !== is;
      const item = make("li", { "data-is": is, title: `${kind}, ${WORDS[is]}`, class: differs ? "differs" : "" },
        make("b", { "aria-label": WORDS[is] }, SIGNS[is] ?? is), name,
        make("span", { class: "message" }, `${kind === name ? "" : ` (${kind})`}${ports ? ` ${ports}` : ""}${message ? ` – ${message}` : ""}`));
      item.style.setProperty("--depth", depth);
      return item;
    }));
    const running = all("[data-is=R]", this.tree), item = find(".differs", this.tree) ?? running[running.length - 1];
    if (item) this.tree.scrollTop = item.offsetTop - this.tree.clientHeight / 3;
  }
}

const runs = data.runs.map((values, number) => new Run(number, values));
const slider = find("#time"), clock = find("#clock"), chart = find(".chart"), line = find(".cursor"), treeOf = find("#tree");
/** The moments to which one can step, in order: a time, and the number of items of each run up to it. */
const stops = allStops();
/** The buttons that show a moment, each with its time and stop: first the key moments. */
const jumps = [...all(".moments .jump"), ...all(".causes .jump")].map((button) => ({ button, ...momentOf(button.dataset) }));
let playing = 0, before = 0, followed = 0, picked;
const cursor = { at: 0, counts: [] };

/** Return the stops: runs go on together up to their first difference, then in order of time. */
function allStops() {
  const counts = runs.map(() => 0), found = [{ at: 0, counts: [...counts] }];
  const first = data.difference?.lines.map((lines, i) => runs[i].itemsUpTo(lines));
  for (let differ = runs.length < 2; ;) {
    const next = runs.map((run, i) => run.items[counts[i]]);
    if (!next.some(Boolean)) return found;
    const ats = next.map((item) => item?.at ?? Infinity);
    const which = ats[1] < ats[0] ? 1 : 0;
    const apart = next.findIndex((item, i) => item && !item.compared && counts[i] < (first?.[i] ?? Infinity));
    if (differ) counts[which] += 1;
    else if (first?.every((count, i) => count === counts[i])) {
      differ = true;
      data.difference.seen.forEach((lines, i) => { counts[i] = runs[i].itemsUpTo(lines); });
      found.difference = found.length;
      found.push({ at: data.difference.at, counts: [...counts] });
      continue;
    } else if (apart >= 0) counts[next[which] && !next[which].compared ? which : apart] += 1;
    else next.forEach((item, i) => { if (item) counts[i] += 1; });
    const at = Math.max(found[found.length - 1].at, ...runs.map((run, i) => run.items[counts[i] - 1]?.at ?? 0));
    found.push({ at, counts: [...counts] });
  }
}

/** Return the time and the stop of a violation, of an event of the first run, or of the end of an instant. */
function momentOf({ at, seen, violated }) {
  const time = Math.min(data.whole, Number(at));
  if (violated === undefined && seen === undefined) return { at: time, stop: lastStop(time) };
  const count = violated === undefined ? runs[0].itemsUpTo(Number(seen)) : runs[0].items.findIndex((item) => item.violation === Number(violated)) + 1;
  const stop = stopOf(0, count);
  return { at: stops[stop].at, stop };
}

/** Return the last stop up to a time. */
function lastStop(at) {
  return countUpTo(stops, at, (each) => each.at) - 1;
}

/** Return the first stop after a number of items of a run. */
function stopOf(number, count) {
  return stops.findIndex(({ counts }) => counts[number] >= count);
}

/** Show a time, at the end of its instant, or within it at a stop. */
function show(at, stop) {
  cursor.at = Math.min(data.whole, Math.max(0, at));
  cursor.stop = stop ?? lastStop(cursor.at);
  cursor.counts = stops[cursor.stop].counts;
  slider.value = cursor.at;
  const text = seconds(cursor.at);
  slider.setAttribute("aria-valuetext", text);
  say(clock, `${text} of ${seconds(data.whole)}${placeInInstant()}`);
  // One element moves, as a property of the chart would restyle all of its bars.
  line.style.left = `calc(var(--names) + (100% - var(--names)) * ${Math.min(1, cursor.at / data.length)})`;
  markJump();
  runs.forEach((run, i) => run.show(cursor.at, cursor.counts[i]));
  showTrees();
  if (playing && performance.now() < followed + FOLLOW) return;
  followed = performance.now();
  runs.forEach((run) => run.follow());
}

/** Mark the button of the moment that is shown: of several, the one that was clicked, or else the first. */
function markJump() {
  const here = jumps.filter(({ at, stop }) => at === cursor.at && stop === cursor.stop);
  const current = here.includes(picked) ? picked : here[0];
  for (const jump of jumps) {
    if (jump === current) jump.button.setAttribute("aria-current", "true");
    else jump.button.removeAttribute("aria-current");
  }
}

/** Return which event is shown of those at its time, in words; empty if it is the only one. */
function placeInInstant() {
  const { at } = stops[cursor.stop];
  // The first stop is before all events.
  const before = Math.max(1, countUpTo(stops, at - INSTANT, (each) => each.at)), count = countUpTo(stops, at, (each) => each.at) - before;
  return cursor.at > at || count < 2 ? "" : ` · event ${cursor.stop - before + 1} of ${count} at this time`;
}

function showTrees() {
  if (!treeOf) return;
  const ticks = runs.map((run, i) => run.tickOf(treeOf.value, cursor.at, cursor.counts[i]));
  runs.forEach((run, i) => run.showTree(ticks[i], ticks[1 - i]));
}

function showStop(stop) {
  pause();
  show(stops[stop].at, stop);
}

/** Show the moment after a number of items of a run. */
function showItem(number, count) {
  showStop(stopOf(number, count));
}

/** Step to the next stop, or to the previous one. */
function step(by) {
  const back = by < 0 && cursor.at > stops[cursor.stop].at ? 0 : by;
  showStop(Math.min(stops.length - 1, Math.max(0, cursor.stop + back)));
}

function showDifference() {
  if (data.difference) showStop(stops.difference);
}

const play = find("#play"), speed = find("#speed");

function pause() {
  cancelAnimationFrame(playing);
  playing = 0;
  say(play, "▶");
  play.setAttribute("aria-pressed", "false");
}

function frame(now) {
  show(Math.min(data.length, cursor.at + ((now - before) / 1000) * Number(speed.value)));
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
/** Return whether a key is for the page, whatever has the focus: only a select uses letters and space itself. */
const applies = (event) => !event.ctrlKey && !event.altKey && !event.metaKey && event.target.tagName !== "SELECT";

document.addEventListener("keydown", (event) => {
  const act = { " ": toggle, n: () => step(1), p: () => step(-1), d: showDifference }[event.key];
  if (!act || !applies(event)) return;
  event.preventDefault();
  act();
});
// Or the button with the focus would be pressed, too.
document.addEventListener("keyup", (event) => event.key === " " && applies(event) && event.preventDefault());
for (const jump of jumps) {
  jump.button.addEventListener("click", () => {
    pause();
    picked = jump;
    show(jump.at, jump.stop);
    find(".map").scrollIntoView({ block: "nearest" });
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
const violated = runs[0].items.findIndex((item) => item.kind === "violated");
if (data.difference) showDifference();
else if (violated >= 0) showItem(0, violated + 1);
else show(0);
document.documentElement.dataset.ready = "true";
