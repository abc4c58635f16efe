// Creates model, source, map and panels, and runs the page.

import { App } from './app.js';
import { Commands } from './commands.js';
import { MapView } from './map/view.js';
import { Model } from './model/model.js';
import { guarded } from './panels/dom.js';
import { SimClock } from './source/clock.js';
import { Connection } from './source/connection.js';
import { Live } from './source/live.js';
import { Playback } from './source/playback.js';
import { fetchRecording, fetchSource } from './source/recording.js';

const PANELS = 250; // ms from one rendering of the panels to the next
const RETRY = 2000; // ms
const WAITING = {
  connecting: 'Connecting to the simulator…',
  lost: 'No simulator yet. Trying again…',
  'no server': 'Lost the connection to the server of this page. Trying again…',
};

const asked = new URLSearchParams(location.search);

/** Return an address of this server, with the page's token. */
function address(path, protocol = location.protocol) {
  const url = new URL(path, location.href);
  url.protocol = protocol;
  const token = asked.get('token');
  if (token) url.searchParams.set('token', token);
  return url.href;
}

const loading = document.getElementById('loading');
const say = (text) => (loading.lastElementChild.textContent = text);

/** Return the kind of source; wait for the server if it does not answer. */
async function sourceOf() {
  for (;;) {
    try {
      return await fetchSource(address('source'));
    } catch (error) {
      say(`${error.message}. Trying again…`);
      await new Promise((resolve) => setTimeout(resolve, RETRY));
    }
  }
}

async function begin() {
  const palette = await (await fetch(address('palette.json'))).json();
  const source = await sourceOf();
  const [model, clock] = [new Model(), new SimClock()];
  const parts = { model, clock, palette, asked };
  if (source.kind === 'recording') {
    const onProgress = (share) => say(`Loading ${source.name}, ${Math.round(share * 100)} %`);
    parts.playback = new Playback(await fetchRecording(source, address('recording'), onProgress), model, clock);
  } else {
    parts.connection = new Connection(address('ws', location.protocol === 'https:' ? 'wss:' : 'ws:'));
    parts.commands = new Commands(parts.connection, model, clock);
    parts.live = new Live(parts.connection, model, clock, async () => (await fetch(address('log'))).json());
  }
  parts.map = new MapView(document.getElementById('map'), model, clock, palette);
  run(new App(parts), parts);
}

function run(app, { model, map, clock, live, playback, connection, commands }) {
  let next = 0;
  const frame = (wallMs) => {
    requestAnimationFrame(frame);
    guarded(map.element, () => map.draw(wallMs));
    if (wallMs < next) return;
    next = wallMs + PANELS;
    live?.flush();
    app.render();
  };
  requestAnimationFrame(frame);
  const root = document.documentElement;
  const tell = () => {
    root.dataset.state = live?.state ?? 'recording';
    if (!app.shown) say(WAITING[live?.state] ?? WAITING.connecting);
  };
  live?.addEventListener('state', tell);
  tell();
  const ready = () => {
    if (app.shown || !model.world.known) return;
    loading.remove();
    root.dataset.ready = 'true';
    app.begin();
    window.hmrsim = { model, map, clock, live, playback, connection, commands, version: model.info?.hmrsim ?? '' };
  };
  model.addEventListener('scene', ready);
  if (model.robots.size) ready();
}

begin().catch((error) => {
  loading.dataset.failed = 'true';
  say(`The page can't be shown: ${error.message}`);
  console.error(error);
});
