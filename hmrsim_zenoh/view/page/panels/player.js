// The bar of time of a recording: a scrubber with marks, speed, and jumps from mark to mark.

import { button, el, icon, mark, say } from './dom.js';
import { clockWords } from './phrases.js';

const SPEEDS = [0.25, 0.5, 1, 2, 5, 10, 20, 50, 100];
const PARTS = 10000;

export class Player {
  /** @param {import('../app.js').App} app */
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
    const speed = el('select', {
      class: 'field speed', 'aria-label': 'Speed', onchange: () => (playback.speed = Number(speed.value)),
    }, ...SPEEDS.map((each) => el('option', { value: each, text: `× ${each}` })));
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

  /** Return the marks; where many are close together the last of them is shown. */
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
      this.play.replaceChildren(icon(this.pressed ? 'pause' : 'play'));
      mark(this.play, 'aria-label', this.pressed ? 'Pause' : 'Play');
      mark(this.play, 'title', this.pressed ? 'Pause (space)' : 'Play (space)');
    }
    say(this.time, clockWords(playback.time, 1));
    const value = String(Math.round(((playback.time - playback.begin) / this.length) * PARTS));
    if (this.range.value !== value) this.range.value = value;
    mark(this.range, 'aria-valuetext', clockWords(playback.time, 1));
  }
}
