// The time bars: of a live simulation with pause, step and speed, and of a recording with a scrubber and marks.

import { button, el, mark, say, showPlayButton, speedField, speedOption } from './dom.js';
import { clockWords } from './phrases.js';

const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 3, 5, 10, 20, 50, 100];
const AS_FAST_AS_POSSIBLE = 0;
const MEASURED = 3000; // ms over which the achieved factor is measured

export class TimeBar {
  constructor(app) {
    this.app = app;
    this.pressed = null;
    this.samples = [];
    this.play = button('pause', 'Pause', () => this.toggle(), { key: 'space', class: 'round primary' });
    this.step = button('step', 'Step', () => this.stepOnce(), { key: '.', class: 'round' });
    this.time = el('output', { class: 'time', 'aria-label': 'Simulated time', 'aria-live': 'off' });
    this.achieved = el('span', { class: 'achieved' });
    this.speed = speedField(() => this.#choose());
    this.#options(SPEEDS);
    this.element.append(this.play, this.step, el('div', { class: 'time-words' }, this.time, this.achieved), this.speed);
    app.live.addEventListener('time', () => this.render());
  }

  element = el('div', { class: 'time-bar', role: 'toolbar', 'aria-label': 'Time' });

  toggle() {
    const paused = this.app.live.timeState?.paused;
    this.app.orders.ask(paused ? 'resume' : 'pause', () => (paused ? this.app.commands.resume() : this.app.commands.pause()));
  }

  stepOnce() {
    if (!this.app.live.timeState?.paused) this.app.toasts.show('info', 'Pause the simulation first, then step.');
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
    for (const control of [this.play, this.step, this.speed]) control.disabled = !there;
    const now = this.app.now();
    say(this.time, clockWords(now, 1));
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

  #renderPaused(paused) {
    if (paused === this.pressed) return;
    this.pressed = paused;
    showPlayButton(this.play, !paused, paused ? 'Resume' : 'Pause');
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

export class Player {
  constructor(app) {
    this.app = app;
    const { playback } = app;
    this.pressed = null;
    this.play = button('play', 'Play', () => this.toggle(), { key: 'space', class: 'round primary' });
    const previous = button('previous', 'Previous mark', () => this.jump(-1), { key: '[', class: 'round' });
    const next = button('next', 'Next mark', () => this.jump(1), { key: ']', class: 'round' });
    this.time = el('output', { class: 'time', 'aria-live': 'off', 'aria-label': 'Time' });
    this.whole = el('span', { class: 'achieved', text: `of ${clockWords(playback.end)}${playback.truncated ? ', truncated' : ''}` });
    this.range = el('input', {
      type: 'range', class: 'scrubber', min: 0, max: PARTS, step: 1, value: 0, 'aria-label': 'Time in the recording',
      oninput: () => playback.seek(playback.begin + (this.range.value / PARTS) * this.length),
    });
    const speed = speedField(() => (playback.speed = Number(speed.value)));
    speed.append(...PLAYBACK_SPEEDS.map(speedOption));
    speed.value = String(playback.speed);
    this.element = el('div', { class: 'time-bar recording', role: 'toolbar', 'aria-label': 'Recording' },
      previous, this.play, next, el('div', { class: 'time-words' }, this.time, this.whole),
      el('div', { class: 'track' }, this.#marks(), this.range), speed);
    playback.addEventListener('time', () => (this.stale = true));
  }

  get length() {
    return Math.max(this.app.playback.end - this.app.playback.begin, 1e-9);
  }

  toggle() {
    const { playback } = this.app;
    if (playback.playing) playback.pause();
    else playback.play();
    this.render();
  }

  stepOnce() {
    this.app.playback.pause();
    this.app.playback.seek(this.app.playback.time + 0.1);
  }

  jump(direction) {
    const found = this.app.playback.jump(direction);
    if (found) this.app.toasts.show('info', `${clockWords(found.t, 1)} ${found.text}`);
    else this.app.toasts.show('info', direction > 0 ? 'No later mark.' : 'No earlier mark.');
  }

  /** Return the marks; of marks close together only the last is shown. */
  #marks() {
    const box = el('div', { class: 'marks', 'aria-hidden': 'true' });
    const places = new Map();
    for (const each of this.app.playback.marks) {
      places.set(Math.round(((each.t - this.app.playback.begin) / this.length) * 300), each);
    }
    for (const [place, { kind, text }] of places) {
      const line = el('i', { data: { kind }, title: text });
      line.style.left = `${place / 3}%`;
      box.append(line);
    }
    return box;
  }

  render() {
    const { playback } = this.app;
    if (playback.playing !== this.pressed) {
      this.pressed = playback.playing;
      showPlayButton(this.play, this.pressed, this.pressed ? 'Pause' : 'Play');
    }
    say(this.time, clockWords(playback.time, 1));
    const value = String(Math.round(((playback.time - playback.begin) / this.length) * PARTS));
    if (this.range.value !== value) this.range.value = value;
    mark(this.range, 'aria-valuetext', clockWords(playback.time, 1));
  }
}
