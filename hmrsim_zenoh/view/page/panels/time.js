// The time bars: of a live simulation with pause, step and speed, and of a recording; both with a slider of the past.

import { clockWords, lastingWords } from '../model/phrases.js';
import { button, el, mark, say, showPlayButton } from './dom.js';

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 3, 5, 10, 20, 50, 100];
const PLAYBACK_SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
const AS_FAST_AS_POSSIBLE = 0;
const MEASURED = 3000; // ms over which the achieved factor is measured
const STEP = 0.1; // seconds
const BACK = 5; // seconds
const PARTS = 10000; // of the slider
const MARKS = 300; // places of marks

/** Return a choice of speeds. */
function speedField(factors, onchange) {
  return el('select', { class: 'field speed', 'aria-label': 'Speed', onchange }, ...factors.map(speedOption));
}

function speedOption(factor) {
  return el('option', { value: factor, text: factor === AS_FAST_AS_POSSIBLE ? 'fastest' : `× ${factor}` });
}

/** What both bars have: play, time, and the speed and slider of a timeline; of marks close together only the last is shown. */
class Bar {
  constructor(app, timeline, label) {
    Object.assign(this, { app, timeline, pressed: null });
    this.play = button('play', 'Play', () => this.toggle(), { key: 'space', class: 'round primary' });
    this.time = el('output', { class: 'time', 'aria-live': 'off', 'aria-label': 'Simulated time' });
    this.note = el('span', { class: 'achieved' });
    this.words = el('div', { class: 'time-words' }, this.time, this.note);
    this.marks = el('div', { class: 'marks', 'aria-hidden': 'true' });
    this.range = el('input', {
      type: 'range', class: 'scrubber', min: 0, max: PARTS, step: 1, value: 0, 'aria-label': label,
      oninput: () => timeline.seek(timeline.begin + (this.range.value / PARTS) * this.#length),
    });
    this.track = el('div', { class: 'track' }, this.marks, this.range);
    this.pace = speedField(PLAYBACK_SPEEDS, () => (timeline.speed = Number(this.pace.value)));
    this.pace.value = String(timeline.speed);
    this.element = el('div', { class: 'time-bar wide', role: 'toolbar', 'aria-label': 'Time' });
    timeline.addEventListener('state', () => app.render());
  }

  get #length() { return Math.max(this.timeline.end - this.timeline.begin, 1e-9); }

  #renderTrack(time) {
    const place = (t, parts) => Math.round(((t - this.timeline.begin) / this.#length) * parts);
    const value = String(place(time, PARTS));
    if (this.range.value !== value) this.range.value = value;
    mark(this.range, 'aria-valuetext', clockWords(time, 1));
    const places = new Map(this.timeline.marks.map((each) => [place(each.t, MARKS), each]));
    const drawn = Array.from(places, ([at, { kind }]) => `${at}${kind}`).join();
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    this.marks.replaceChildren(...Array.from(places, ([at, { kind, text }]) => {
      const line = el('i', { data: { kind }, title: text });
      line.style.left = `${(at * 100) / MARKS}%`;
      return line;
    }));
  }

  toggle() {
    if (this.timeline.playing) this.timeline.pause();
    else this.timeline.play();
  }

  stepOnce() { this.#move(STEP); }

  back() { this.#move(-BACK); }

  #move(seconds) {
    this.timeline.pause();
    this.timeline.seek(this.timeline.time + seconds);
  }

  jump(direction) {
    const found = this.timeline.jump(direction);
    const none = direction > 0 ? 'No later mark.' : 'No earlier mark.';
    this.app.toasts.show('info', found ? `${clockWords(found.t, 1)} ${found.text}` : none);
  }

  /** Show the time, and whether it stands; *resume* is the label of the button that lets it go on. */
  show(time, paused, resume) {
    say(this.time, clockWords(time, 1));
    this.#renderTrack(time);
    const pressed = `${paused} ${resume}`;
    if (pressed === this.pressed) return;
    this.pressed = pressed;
    showPlayButton(this.play, !paused, paused ? resume : 'Pause');
    mark(this.element, 'data-paused', paused);
  }
}

export class Player extends Bar {
  constructor(app) {
    const { playback } = app;
    super(app, playback, 'Time in the recording');
    const previous = button('previous', 'Previous mark', () => this.jump(-1), { key: '[', class: 'round' });
    const next = button('next', 'Next mark', () => this.jump(1), { key: ']', class: 'round' });
    say(this.note, `of ${clockWords(playback.end)}${playback.truncated ? ', truncated' : ''}`);
    this.element.append(previous, this.play, next, this.words, this.track, this.pace);
  }

  render() { this.show(this.timeline.time, !this.timeline.playing, 'Play'); }
}

export class TimeBar extends Bar {
  constructor(app) {
    super(app, app.live.rewind, 'Time of the simulation');
    this.samples = [];
    this.step = button('step', 'Step', () => this.stepOnce(), { key: '.', class: 'round' });
    this.present = el('button', {
      type: 'button', class: 'button live-button', text: 'Live', title: 'Return to the present (esc)', onclick: () => this.timeline.leave(),
    });
    this.speed = speedField([...SPEEDS, AS_FAST_AS_POSSIBLE], () => this.#choose());
    this.element.append(this.play, this.step, this.words, this.track, this.present, this.speed);
    app.live.addEventListener('time', () => this.render());
    this.timeline.addEventListener('active', () => (app.aim(null), app.render()));
  }

  toggle() {
    const { commands, live, orders } = this.app;
    if (this.timeline.active) super.toggle();
    else if (live.timeState?.paused) orders.ask('resume', () => commands.resume());
    else orders.ask('pause', () => commands.pause());
  }

  stepOnce() {
    const { commands, live, orders, toasts } = this.app;
    if (this.timeline.active) super.stepOnce();
    else if (!live.timeState?.paused) toasts.show('info', 'Pause the simulation first, then step.');
    else orders.ask('make a step', () => commands.step(1));
  }

  #choose() {
    const factor = Number(this.speed.value);
    this.app.orders.ask('change the speed', () => this.app.commands.setSpeed(factor)).finally(() => this.render());
  }

  render() {
    const { live: { timeState: state, state: connected } } = this.app;
    const there = connected === 'live' && state !== null;
    const { active, time } = this.timeline;
    for (const control of [this.play, this.step, this.speed]) control.disabled = !there && !active;
    mark(document.body, 'data-past', active);
    mark(this.present, 'aria-pressed', !active);
    const [speed, other] = active ? [this.pace, this.speed] : [this.speed, this.pace];
    if (!speed.isConnected) other.replaceWith(speed);
    this.show(time, active ? !this.timeline.playing : state?.paused === true, active ? 'Play' : 'Resume');
    if (active) say(this.note, `${lastingWords(this.timeline.end - time)} ago`);
    else if (there) this.#renderLive(state);
    else say(this.note, '');
  }

  #renderLive(state) {
    const lockstep = state.clock === 'lockstep';
    this.speed.hidden = lockstep;
    const factor = String(state.real_time_factor);
    const offered = Array.from(this.speed.options, ({ value }) => value);
    if (!offered.includes(factor)) {
      const factors = [...SPEEDS, state.real_time_factor].sort((a, b) => a - b);
      this.speed.replaceChildren(...[...factors, AS_FAST_AS_POSSIBLE].map(speedOption));
    }
    if (document.activeElement !== this.speed && this.speed.value !== factor) this.speed.value = factor;
    this.#renderAchieved(state, this.#measure(), lockstep);
  }

  #renderAchieved({ paused, real_time_factor: wanted, waiting_for: awaited, participants }, factor, lockstep) {
    const achieved = `× ${factor >= 10 ? factor.toFixed(0) : factor.toFixed(1)}`;
    let text = achieved;
    if (paused) text = 'paused';
    else if (lockstep && !participants?.length) text = 'lockstep · no participants';
    else if (lockstep) text = `lockstep · ${awaited?.length ? `waiting for ${awaited.join(', ')}` : achieved}`;
    else if (wanted) text += ` of ${wanted}`;
    else if (factor < 0.05) text = 'idle';
    say(this.note, text);
    const slow = !paused && !lockstep && wanted > 0 && factor < 0.85 * wanted;
    mark(this.note, 'data-slow', slow && this.samples.length > 6);
    mark(this.note, 'title', slow ? 'The machine cannot keep up with the requested speed' : '');
  }

  /** Return the recent simulated seconds per wall second. */
  #measure() {
    const [wall, now, { samples }] = [performance.now(), this.app.now(), this];
    const { paused, real_time_factor: rate } = this.app.live.timeState;
    if (samples.length && (now < samples.at(-1)[1] || rate !== this.rate || paused)) samples.length = 0;
    this.rate = rate;
    samples.push([wall, now]);
    while (samples.length > 2 && samples[0][0] < wall - MEASURED) samples.shift();
    const [first, before] = samples[0];
    return wall > first ? ((now - before) * 1000) / (wall - first) : rate;
  }
}
