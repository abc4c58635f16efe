// The page as a whole: selection, aiming, following, open panels, and the operations that panels use.

import { middle } from './model/motion.js';
import { Orders } from './orders.js';
import { ChartsPanel } from './panels/charts.js';
import { button, el, guarded, mark } from './panels/dom.js';
import { EventsPanel } from './panels/events.js';
import { FormDialog } from './panels/form.js';
import { GoalsPanel } from './panels/goals.js';
import { Inspector } from './panels/inspector.js';
import { Keyboard } from './panels/keyboard.js';
import { Menu } from './panels/menu.js';
import { Banner, Hint, Toasts } from './panels/notices.js';
import { OrdersPanel } from './panels/orders.js';
import { RobotsPanel } from './panels/robots.js';
import { Search } from './panels/search.js';
import { Legend, Side, Summary, Theme } from './panels/shell.js';
import { Player, TimeBar } from './panels/time.js';
import { TreesPanel } from './panels/trees.js';

const ZOOM = 60; // css pixels covered by the zoom buttons at the left
/** The kinds of objects with names, those first that a name stands for if several have it. */
const KINDS = ['robot', 'item', 'lift', 'waypoint', 'place', 'dock', 'door'];
const PHONE = matchMedia('(max-width: 700px), (max-width: 1000px) and (orientation: portrait)'); // as in style.css

export class App {
  /** @param {object} parts See main.js. */
  constructor({ model, clock, map, palette, asked, connection, commands, live, playback }) {
    Object.assign(this, { model, clock, map, palette, asked, connection, commands, live, playback });
    this.shown = false;
    this.aimed = null; // the robot that is sent to the next click
    this.toasts = new Toasts();
    this.orders = new Orders(this);
    this.banner = new Banner(this);
    this.search = new Search(this);
    this.summary = new Summary(this);
    this.inspector = new Inspector(this);
    this.time = playback ? new Player(this) : new TimeBar(this);
    this.menu = new Menu(this);
    this.form = new FormDialog(this);
    this.hint = new Hint(this);
    this.panels = new Side(this, {
      robots: new RobotsPanel(this), goals: new GoalsPanel(this), orders: new OrdersPanel(this),
      events: new EventsPanel(this), trees: new TreesPanel(this), charts: new ChartsPanel(this),
    });
    this.legendButton = button('layers', 'Legend and layers', () => this.legend.toggle(), { key: 'l' });
    this.legend = new Legend(this);
    this.keyboard = new Keyboard(this);
    this.theme = new Theme(this);
    this.#place();
    this.#listen();
    this.theme.begin();
  }

  #place() {
    const help = button('help', 'Keyboard shortcuts', () => this.keyboard.help(), { key: '?' });
    const zoom = el('div', { class: 'card zoom', role: 'group', 'aria-label': 'Map' },
      button('plus', 'Zoom in', () => this.zoom(1.35), { key: '+' }), button('minus', 'Zoom out', () => this.zoom(1 / 1.35), { key: '-' }),
      button('fit', 'Show all', () => this.fit(), { key: '0' }), this.legendButton);
    this.panels.tabs.classList.add('card');
    document.getElementById('shell').append(
      el('div', { class: 'top' }, el('div', { class: 'card brand' }, this.summary.element, this.search.element),
        this.hint.element, el('div', { class: 'top-right' }, this.panels.tabs, el('div', { class: 'card corner-tools' }, this.theme.button, help))),
      el('div', { class: 'right' }, this.inspector.element, this.panels.element), zoom, this.legend.element,
      el('div', { class: 'bottom' }, this.toasts.element, this.time.element),
      this.banner.element, this.menu.element, this.form.element, this.keyboard.element);
  }

  #listen() {
    const { map } = this;
    map.addEventListener('pick', ({ detail }) => this.#picked(detail));
    map.addEventListener('menu', ({ detail }) => detail && this.menu.open(detail));
    map.addEventListener('hover', ({ detail }) => {
      if (this.aimed !== null) map.goalPreview = detail && detail.kind !== 'robot' ? detail.point : null;
    });
    map.addEventListener('follow', () => this.render());
    this.model.addEventListener('world', () => this.layout());
    if (this.model.unreadable) this.#tellUnreadable('in this recording ');
    else this.model.addEventListener('unreadable', ({ detail }) => this.#tellUnreadable(`on ${detail} `), { once: true });
    PHONE.addEventListener('change', () => this.layout());
    addEventListener('resize', () => this.layout());
  }

  #tellUnreadable(where) { this.toasts.show('error', `A message ${where}can't be read and is ignored.`, 'Further ones are ignored without notice.'); }

  /** Start when the first world has arrived. */
  begin() {
    this.shown = true;
    const panel = this.asked.get('panel');
    this.panels.show(panel ?? (PHONE.matches || innerWidth < 1000 ? null : 'goals'));
    this.layout();
    if (this.map.camera.fitted !== false) this.map.camera.fit(false);
    const follow = this.asked.get('follow');
    if (follow && this.model.robots.has(follow)) {
      this.select(follow, { center: true });
      this.follow(follow);
    }
    this.hint.welcome();
    this.playback?.play();
  }

  /** @returns {boolean} Whether requests may be sent: there is a simulator, and the page shows its present. */
  get commanding() { return this.live?.state === 'live' && !this.live.rewind.active; }

  now() { return this.clock.now(); }

  /** Render the open parts; called a few times per second. */
  render() {
    guarded(this.banner.element, () => this.banner.render());
    if (!this.shown) return;
    if (this.map.selected !== null && !this.model.robots.has(this.map.selected)) this.select(null);
    const gone = this.live && this.live.state !== 'live';
    mark(document.body, 'data-gone', Boolean(gone));
    for (const part of [this.summary, this.time, this.inspector, this.panels]) guarded(part.element, () => part.render());
  }

  /** Select a robot, or none. @param {boolean} [options.center] Whether to center it if it is out of sight or covered. */
  select(name, { center = false } = {}) {
    const robot = name === null ? undefined : this.model.robots.get(name);
    if (this.aimed !== null && this.aimed !== name) this.aim(null);
    if (this.map.follow !== null && this.map.follow !== name) this.map.follow = null;
    this.map.selected = robot ? name : null;
    this.live?.watchFeedback(robot ? name : null);
    this.live?.watchDetections(robot?.sensors.length ? name : null);
    if (robot && PHONE.matches) this.panels.show(null);
    this.render();
    this.layout();
    const [x, y] = robot?.poseAt(this.now()) ?? [];
    if (robot && center && !this.map.camera.shows(x, y)) this.map.camera.centerOn(x, y);
  }

  selectNext(step) {
    const names = [...this.model.robots.keys()];
    const at = names.indexOf(this.map.selected);
    if (names.length) this.select(names[(at < 0 && step < 0 ? names.length - 1 : at + step + names.length) % names.length], { center: true });
  }

  /**
   * @param {string|undefined} name The name of anything on the map.
   * @param {string} [kind] The kind, as a door and a place may share a name; by default any.
   * @returns {number[]|undefined} Its position.
   */
  pointOf(name, kind) {
    if (kind === undefined) return KINDS.map((each) => this.pointOf(name, each)).find(Boolean);
    const thing = this.model.allOf(kind)?.get(name);
    if (kind === 'door') return thing && middle(...thing.at);
    return kind === 'robot' ? thing?.poseAt(this.now()) : thing?.at;
  }

  /** Select the first robot among names, or else center on the first object that is on the map. */
  show(names) {
    const robot = names.find((name) => this.model.robots.has(name));
    if (robot) this.select(robot, { center: true });
    else this.centerOn(names.find((name) => this.pointOf(name)));
  }

  centerOn(name, kind) {
    const point = this.pointOf(name, kind);
    if (!point) return;
    this.map.follow = null;
    this.map.camera.centerOn(point[0], point[1]);
  }

  follow(name) {
    this.map.follow = this.map.follow === name ? null : name;
    if (this.map.follow !== null && this.map.selected !== name) this.select(name);
    this.hint.show(this.map.follow ? `Following ${name}. Drag the map to stop.` : '', 2500);
    this.render();
  }

  fit() {
    this.map.follow = null;
    this.map.camera.fit();
  }

  zoom(factor) {
    const { clientWidth, clientHeight } = this.map.element;
    this.map.camera.zoomAt(clientWidth / 2, clientHeight / 2, factor, true);
  }

  pan(dx, dy) {
    this.map.follow = null;
    this.map.camera.panBy(dx, dy);
  }

  openMenuOfSelected() {
    const robot = this.model.robots.get(this.map.selected);
    if (!robot) return;
    const [x, y] = robot.poseAt(this.now());
    const [px, py] = this.map.toScreen(x, y);
    this.menu.open({ kind: 'robot', name: robot.name, point: [x, y], px, py });
  }

  escape() {
    if (!this.menu.element.hidden) this.menu.close();
    else if (this.aimed !== null) this.aim(null);
    else if (this.live?.rewind.active) this.live.rewind.leave();
    else if (this.map.follow !== null) this.follow(this.map.follow);
    else if (this.map.selected !== null) this.select(null);
    else if (!this.legend.element.hidden) this.legend.toggle();
    else this.panels.show(null);
  }

  /** Send a robot to the next click; null cancels. */
  aim(name) {
    if (name !== null && !this.commanding) return;
    if (name !== null && this.map.selected !== name) this.select(name);
    this.aimed = name;
    this.map.goalPreview = null;
    this.map.element.classList.toggle('aiming', name !== null);
    this.hint.show(name === null ? '' : `Click where ${name} should go`, 0, 'Esc');
  }

  #picked(pick) {
    this.hint.known();
    if (pick.kind === 'robot') {
      const again = pick.name === this.map.selected && this.aimed !== null;
      this.select(pick.name);
      this.aim(again ? null : pick.name);
    } else if (this.aimed !== null) {
      this.orders.send(this.aimed, pick);
    } else {
      this.select(null);
    }
  }

  /** Tell the camera which parts of the map are covered. */
  layout() {
    const { camera } = this.map;
    if (!camera.insets || !this.shown) return;
    const phone = PHONE.matches;
    const open = !this.panels.element.hidden;
    const side = document.querySelector('.right').getBoundingClientRect();
    const top = document.querySelector('.top-right').getBoundingClientRect();
    const bottom = innerHeight - this.time.element.getBoundingClientRect().top;
    const covered = open || !this.inspector.element.hidden;
    const insets = {
      top: top.bottom, left: phone ? 0 : ZOOM, right: covered && !phone ? innerWidth - side.left : 0,
      bottom: phone ? this.#sheet(open, bottom) : bottom,
    };
    if (Object.entries(insets).every(([edge, width]) => camera.insets[edge] === width)) return;
    Object.assign(camera.insets, insets);
    this.map.changed(false);
    if (camera.fitted) camera.fit(phone || covered);
  }

  /** Return the height that a phone's sheet or the selected robot's card covers. */
  #sheet(open, bottom) {
    if (open) return this.panels.element.offsetHeight;
    return this.inspector.element.hidden ? bottom : innerHeight - this.inspector.element.getBoundingClientRect().top;
  }
}
