"""Fixtures for the page in a real browser, with real simulators."""

from __future__ import annotations

import base64
import json
import os
import shutil
import signal
import subprocess
import uuid
from urllib.parse import urlsplit

import pytest

from benchmarks import _browser
from hmrsim_zenoh import Client, SessionOptions
from hmrsim_zenoh.wire.keys import Verb
from tests import processes
from tests.paths import ROOT
from tests.patience import PATIENCE


@pytest.fixture(scope="module")
def browser():
    """Return a headless Chromium, one for each module, as its event loop disturbs other tests."""
    playwright = pytest.importorskip("playwright.sync_api", reason="the page is tried by playwright")
    playwright.expect.set_options(timeout=PATIENCE * 1000)
    if not any(map(shutil.which, _browser.NAMES)):
        pytest.skip("the page is tried in Chromium, which is not installed")
    with _browser.browser() as chromium:
        yield chromium


class Watched:
    """The problems of a page: console messages, failed requests, other hosts."""

    def __init__(self, page, url):
        self._host = urlsplit(url).netloc
        self.found = []
        page.on("console", self._heard)
        page.on("pageerror", lambda error: self.found.append(f"error: {error}"))
        page.on("requestfailed", lambda request: self.found.append(f"failed: {request.url} {request.failure}"))
        page.on("request", lambda request: self._asked(request.url))
        page.on("websocket", lambda socket: self._asked(socket.url))

    def _heard(self, message):
        if message.type in ("error", "warning", "assert"):
            self.found.append(f"console: {message.text}")

    def _asked(self, url):
        parts = urlsplit(url)
        if parts.scheme not in ("data", "blob") and parts.netloc != self._host:
            self.found.append(f"another host: {url}")


@pytest.fixture
def open_page(browser):
    """Return the function that opens a page and waits for its world; what went wrong there fails the test.

    So does what the page can't read, but for what *unreadable* says.
    """
    opened = []

    def load(url, *, unreadable=0, **context):
        page = browser.new_context(**{"viewport": {"width": 1280, "height": 800}, **context}).new_page()
        page.set_default_timeout(PATIENCE * 1000)
        opened.append((page, Watched(page, url), unreadable))
        return _browser.shown(page, url)

    yield load
    found = [complaint for _, watched, _ in opened for complaint in watched.found]
    left_out = [page.evaluate("window.hmrsim?.model.unreadable ?? 0") for page, _, _ in opened]
    for page, _, _ in opened:
        page.context.close()
    assert found == []
    assert [unreadable for _, _, unreadable in opened] == left_out


class Process:
    """A process of hmrsim, with its first line of output."""

    def __init__(self, *arguments, env=None):
        self.process = processes.start(
            "hmrsim",
            *arguments,
            stderr=subprocess.DEVNULL,
            cwd=ROOT,
            env={
                **{name: value for name, value in os.environ.items() if not name.startswith("HMRSIM_")},
                **(env or {}),
            },
        )
        self.ready = json.loads(self.process.stdout.readline() or "null")
        assert self.ready, f"{arguments}: said nothing, and ended with {self.process.wait()}"

    def end(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
        if not self.process.stdout.closed:
            self.process.communicate()
        return self.process.returncode


@pytest.fixture
def start():
    """Return the function that starts commands of hmrsim that print a JSON object when they are ready."""
    started = []

    def run(*arguments, **options):
        started.append(Process(*arguments, "--json", **options))
        return started[-1]

    yield run
    for one in reversed(started):
        one.end()


@pytest.fixture
def viewed(start):
    """Return the function that runs a world and a view server: endpoint and URL."""

    def run(world, *arguments):
        simulator = start("run", world, "--listen", "tcp/127.0.0.1:0", *arguments)
        endpoint = simulator.ready["endpoints"][0]
        view = start("view", "--connect", endpoint, "--port", 0)
        return endpoint, view.ready["url"]

    return run


@pytest.fixture
def client():
    """Return the function that connects to a simulator."""
    opened = []

    def connect(endpoint):
        opened.append(Client(SessionOptions(connect=(endpoint,)), clock="realtime"))
        return opened[-1]

    yield connect
    for one in opened:
        one.close()


class Asked:
    """A simulator that is queried with plain requests over Zenoh."""

    def __init__(self, client):
        self._client = client

    def tell(self, **event):
        """Publish an event like the world, at the current time."""
        key = self._client.keys.world("events")
        self._client.session.put(key, json.dumps({"stamp": self.scene()["stamp"], **event}))

    def scene(self):
        return json.loads(self._client.get(self._client.keys.world("scene")))

    def robot(self, name):
        return next(robot for robot in self.scene()["robots"] if robot["name"] == name)

    def call(self, service, **request):
        """Call a service of the world and check that it succeeds."""
        reply = json.loads(self._client.get(self._client.keys.world(service), payload=json.dumps(request).encode()))
        assert 1 == reply["result"]["result"], reply
        return reply

    def send(self, robot, action, **goal):
        """Send a goal, which has to be accepted; return its id."""
        goal_id = uuid.uuid4().hex
        key = self._client.keys.action(robot, action, Verb.SEND_GOAL)
        payload = json.dumps({"goal_id": goal_id, "goal": goal}).encode()
        assert json.loads(self._client.get(key, payload=payload))["accepted"]
        return goal_id

    def result(self, robot, action, goal_id):
        """Return the final status of a goal, once it has ended."""
        key = self._client.keys.action(robot, action, Verb.GET_RESULT)
        return json.loads(self._client.get(key, PATIENCE, payload=json.dumps({"goal_id": goal_id}).encode()))["status"]

    def do(self, robot, action, **goal):
        """Send a goal, and return its status when it has ended."""
        return self.result(robot, action, self.send(robot, action, **goal))


@pytest.fixture
def ask(client):
    """Return the function that makes a client that can query a simulator."""
    return lambda endpoint: Asked(client(endpoint))


_COUNT = """async ([png, x, y, radius, colour]) => {
  const image = await createImageBitmap(await (await fetch('data:image/png;base64,' + png)).blob());
  const context = new OffscreenCanvas(image.width, image.height).getContext('2d');
  context.drawImage(image, 0, 0);
  const {data} = context.getImageData(x - radius, y - radius, 2 * radius, 2 * radius);
  let found = 0;
  for (let i = 0; i < data.length; i += 4)
    found += colour.every((value, channel) => Math.abs(data[i + channel] - value) <= 12);
  return found;
}"""


@pytest.fixture
def coloured(browser):
    """Return the function that counts pixels of a color around a point of the world in a screenshot."""
    decoder = browser.new_context().new_page()

    def count(page, point, colour, radius=8):
        page.evaluate("() => new Promise((then) => requestAnimationFrame(() => requestAnimationFrame(then)))")
        x, y = page.evaluate(ON_PAGE, point)
        png = base64.b64encode(page.screenshot()).decode()
        channels = [int(colour[start : start + 2], 16) for start in (1, 3, 5)]
        return decoder.evaluate(_COUNT, [png, round(x), round(y), radius, channels])

    yield count
    decoder.context.close()


ON_PAGE = """([x, y]) => {
  const [left, top] = hmrsim.map.toScreen(x, y);
  const box = hmrsim.map.element.getBoundingClientRect();
  return [box.left + left, box.top + top];
}"""
"""The position of a point of the world on the page."""


@pytest.fixture
def on_page():
    """Return the function that converts a point of the world to a position on a page."""
    return lambda page, point: page.evaluate(ON_PAGE, point)
