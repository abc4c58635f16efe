// The time bars: of a live simulation with pause, step and speed, and of a recording with a scrubber and marks.

import { button, el, mark, say, showPlayButton, speedField, speedOption } from './dom.js';
import { clockWords, lastingWords } from './phrases.js';

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 3, 5, 10, 20, 50, 100];
const AS_FAST_AS_POSSIBLE = 0;
const MEASURED = 3000; // ms over which the achieved factor is measured
const BACK = 5; // seconds

export class TimeBar {
  constructor(app) {
    this.app = app;
    this.pressed = null;
    this.samples = [];
    this.play = button('pause', 'Pause', () => this.toggle(), { key: 'space', class: 'round primary' });
    this.step = button('step', 'Step', () => this.stepOnce(), { key: '.', class: 'round' });
    this.rewind = app.live.rewind;
    this.past = new Controls(app, this.rewind, 'Time of the simulation');
    this.now = el('button', { type: 'button', class: 'button live-button', text: 'Live', title: 'Return to the present (esc)', onclick: () => this.rewind.leave() });
    this.time = el('output', { class: 'time', 'aria-label': 'Simulated time', 'aria-live': 'off' });
    this.achieved = el('span', { class: 'achieved' });
    this.speed = speedField(() => this.#choose());
    this.#options(SPEEDS);
    this.element.append(this.play, this.step, el('div', { class: 'time-words' }, this.time, this.achieved),
      this.past.scrubber.element, this.now, this.speed);
    app.live.addEventListener('time', () => this.render());
    for (const change of ['active', 'state']) this.rewind.addEventListener(change, () => app.render());
  }

  element = el('div', { class: 'time-bar wide', role: 'toolbar', 'aria-label': 'Time' });

  toggle() {
    if (this.rewind.active) {
      this.past.toggle();
      return;
    }
    const paused = this.app.live.timeState?.paused;
    this.app.orders.ask(paused ? 'resume' : 'pause', () => (paused ? this.app.commands.resume() : this.app.commands.pause()));
  }

  back() {
    if (!this.rewind.active) this.rewind.seek(this.rewind.end - BACK);
    else this.past.stepBy(-BACK);
  }

  jump(direction) {
    this.past.jump(direction);
  }

  stepOnce() {
    if (this.rewind.active) this.past.stepBy(STEP);
    else if (!this.app.live.timeState?.paused) this.app.toasts.show('info', 'Pause the simulation first, then step.');
    else this.app.orders.ask('make a step', () => this.app.commands.step(1));
  }

  #choose() {
    const factor = Number(this.speed.value);
    this.app.orders.ask('change the speed', () => this.app.commands.setSpeed(factor)).finally(() => this.render());
  }

  #options(factors) {
    this.speed.replaceChildren(...factors.map(speedOption), el('option', { value: AS_FAST_AS_POSSIBLE, text: 'fastest' }));
  }

  render() {
    const state = this.app.live.timeState;
    const there = this.app.live.state === 'live' && state !== null;
    const { active } = this.rewind;
    for (const control of [this.play, this.step, this.speed]) control.disabled = !there && !active;
    const now = this.app.now();
    say(this.time, clockWords(now, 1));
    mark(document.body, 'data-past', String(active));
    mark(this.now, 'aria-pressed', String(!active));
    this.past.scrubber.render(active ? this.rewind.time : this.rewind.end);
    const [speed, other] = active ? [this.past.speed, this.speed] : [this.speed, this.past.speed];
    if (!speed.isConnected) other.replaceWith(speed);
    if (active) {
      this.#renderPaused(!this.rewind.playing, 'Play');
      say(this.achieved, `${lastingWords(this.rewind.end - now)} ago`);
      return;
    }
    if (!there) {
      say(this.achieved, '');
      return;
    }
    this.#renderPaused(state.paused);
    const lockstep = state.clock === 'lockstep';
    this.speed.hidden = lockstep;
    const factor = String(state.real_time_factor);
    if (![...this.speed.options].some((option) => option.value === factor)) {
      this.#options([...SPEEDS, state.real_time_factor].sort((a, b) => a - b));
    }
    if (document.activeElement !== this.speed && this.speed.value !== factor) this.speed.value = factor;
    this.#renderAchieved(state, this.#measure(), lockstep);
  }

  #renderPaused(paused, resume = 'Resume') {
    if (`${paused}${resume}` === this.pressed) return;
    this.pressed = `${paused}${resume}`;
    showPlayButton(this.play, !paused, paused ? resume : 'Pause');
    mark(this.element, 'data-paused', String(paused));
  }

  #renderAchieved(state, factor, lockstep) {
    const number = factor >= 10 ? factor.toFixed(0) : factor.toFixed(1);
    const progress = state.waiting_for?.length ? `waiting for ${state.waiting_for.join(', ')}` : `× ${number}`;
    const alone = lockstep && !state.participants?.length;
    let text = `× ${number}`;
    if (state.paused) text = 'paused';
    else if (lockstep) text = alone ? 'lockstep · no participants' : `lockstep · ${progress}`;
    else if (state.real_time_factor) text += ` of ${state.real_time_factor}`;
    else if (factor < 0.05) text = 'idle';
    say(this.achieved, text);
    const slow = !state.paused && !lockstep && state.real_time_factor > 0 && factor < 0.85 * state.real_time_factor;
    mark(this.achieved, 'data-slow', String(slow && this.samples.length > 6));
    mark(this.achieved, 'title', slow ? 'The machine cannot keep up with the requested speed' : '');
  }

  /** Return the recent simulated seconds per wall second. */
  #measure() {
    const [wall, now, { samples }] = [performance.now(), this.app.now(), this];
    const { paused, real_time_factor: rate } = this.app.live.timeState;
    if (samples.length && (now < samples[samples.length - 1][1] || rate !== this.rate || paused)) samples.length = 0;
    this.rate = rate;
    samples.push([wall, now]);
    while (samples.length > 2 && samples[0][0] < wall - MEASURED) samples.shift();
    const [first, before] = samples[0];
    return wall > first ? ((now - before) * 1000) / (wall - first) : rate;
  }
}

const PLAYBACK_SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
const PARTS = 10000;
const MARKS = 300; // places of marks

/** The slider of a timeline, with its marks; of marks close together only the last is shown. */
class Scrubber {
  constructor(timeline, label) {
    this.timeline = timeline;
    this.marks = el('div', { class: 'marks', 'aria-hidden': 'true' });
    this.range = el('input', {
      type: 'range', class: 'scrubber', min: 0, max: PARTS, step: 1, value: 0, 'aria-label': label,
      oninput: () => timeline.seek(timeline.begin + (this.range.value / PARTS) * this.#length),
    });
    this.element = el('div', { class: 'track' }, this.marks, this.range);
  }

  get #length() {
    return Math.max(this.timeline.end - this.timeline.begin, 1e-9);
  }

  /** @param {number} time The time of the thumb. */
  render(time) {
    const { begin, marks } = this.timeline;
    const value = String(Math.round(((time - begin) / this.#length) * PARTS));
    if (this.range.value !== value) this.range.value = value;
    mark(this.range, 'aria-valuetext', clockWords(time, 1));
    const places = new Map(marks.map((each) => [Math.round(((each.t - begin) / this.#length) * MARKS), each]));
    const drawn = [...places].map(([place, { kind }]) => `${place}${kind}`).join();
    if (drawn === this.drawn) return;
    this.drawn = drawn;
    this.marks.replaceChildren(...Array.from(places, ([place, { kind, text }]) => {
      const line = el('i', { data: { kind }, title: text });
      line.style.left = `${(place * 100) / MARKS}%`;
      return line;
    }));
  }
}

/** The controls of a timeline: play, step, jump from mark to mark, and speed. */
class Controls {
  constructor(app, timeline, label) {
    Object.assign(this, { app, timeline });
    this.speed = speedField(() => (timeline.speed = Number(this.speed.value)));
    this.speed.append(...PLAYBACK_SPEEDS.map(speedOption));
    this.speed.value = String(timeline.speed);
    this.scrubber = new Scrubber(timeline, label);
  }

  toggle() {
    if (this.timeline.playing) this.timeline.pause();
    else this.timeline.play();
  }

  /** Pause, and seek a time some seconds later or earlier. */
  stepBy(seconds) {
    this.timeline.pause();
    this.timeline.seek(this.timeline.time + seconds);
  }

  jump(direction) {
    const found = this.timeline.jump(direction);
    if (found) this.app.toasts.show('info', `${clockWords(found.t, 1)} ${found.text}`);
    else this.app.toasts.show('info', direction > 0 ? 'No later mark.' : 'No earlier mark.');
  }
}

const STEP = 0.1; // seconds

export class Player {
  constructor(app) {
    this.app = app;
    const { playback } = app;
    this.pressed = null;
    this.controls = new Controls(app, playback, 'Time in the recording');
    this.play = button('play', 'Play', () => this.toggle(), { key: 'space', class: 'round primary' });
    const previous = button('previous', 'Previous mark', () => this.jump(-1), { key: '[', class: 'round' });
    const next = button('next', 'Next mark', () => this.jump(1), { key: ']', class: 'round' });
    this.time = el('output', { class: 'time', 'aria-live': 'off', 'aria-label': 'Time' });
    this.whole = el('span', { class: 'achieved', text: `of ${clockWords(playback.end)}${playback.truncated ? ', truncated' : ''}` });
    this.element = el('div', { class: 'time-bar wide', role: 'toolbar', 'aria-label': 'Recording' },
      previous, this.play, next, el('div', { class: 'time-words' }, this.time, this.whole),
      this.controls.scrubber.element, this.controls.speed);
  }

  toggle() {
    this.controls.toggle();
    this.render();
  }

  stepOnce() {
    this.controls.stepBy(STEP);
  }

  back() {
    this.controls.stepBy(-BACK);
  }

  jump(direction) {
    this.controls.jump(direction);
  }

  render() {
    const { playback } = this.app;
    if (playback.playing !== this.pressed) {
      this.pressed = playback.playing;
      showPlayButton(this.play, this.pressed, this.pressed ? 'Pause' : 'Play');
    }
    say(this.time, clockWords(playback.time, 1));
    this.controls.scrubber.render(playback.time);
  }
}
