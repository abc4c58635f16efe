"""Recording of messages of the simulator and of other publishers by ``hmrsim record``."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest
import zenoh

from hmrsim.cli.record import rosout
from hmrsim.simulation.simulator import Simulator
from hmrsim.simulation.snapshot import scene
from hmrsim.world.model import World
from hmrsim_zenoh.recording import Recording, listener
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.writer import RecordingFile
from hmrsim_zenoh.server.world_info import Description
from hmrsim_zenoh.wire.keys import Keys
from tests.cases import case
from tests.simulation import SMALL_WORLD
from tests.unit.hmrsim_zenoh.recording.conftest import STATE

RESET = {"kind": "reset", "scope": 255, "stamp": {"sec": 2, "nanosec": 0}}
SPAWNED = {"kind": "spawned", "entity": "e", "type": "carrier", "at": [0.0, 0.0]}


class Link:
    """A client whose simulator answers on command."""

    def __init__(self, prefix="hmrsim"):
        """Create a client that has sent no query."""
        self.keys = Keys(prefix)
        self.session = self
        self.asked = []
        self.handlers = {}

    def declare_subscriber(self, key, handler):
        """Keep the callback of the subscriber."""
        self.handlers[key] = handler.callback
        return SimpleNamespace(undeclare=lambda: None)

    def liveliness(self):
        """Return what tokens are watched with."""
        return self

    def ask(self, key, _payload, then, *, timeout):
        """Keep the query, to be answered later."""
        assert timeout
        self.asked.append((key.rpartition("/")[2], then))


class Listening:
    """A listener, with the samples it gets and the state it is given."""

    def __init__(self, path):
        """Begin to listen; the simulator has not answered."""
        self.path = path
        self.link = Link()
        self.file = RecordingFile(path, reproducible=True)
        self.listener = listener.Listener(self.link, Recorder(self.file, rosout))
        simulator = Simulator(World.model_validate(SMALL_WORLD))
        definition = {"world": {"world_resource": {"resource_string": json.dumps(SMALL_WORLD)}}}
        self.answers = {
            "info": json.loads(Description(simulator, lambda: STATE).info()),
            "get_current_world": definition,
            "scene": scene(simulator),
        }

    def answer(self):
        """Answer all that was asked, and take note of it."""
        asked, self.link.asked = self.link.asked, []
        for name, then in asked:
            then(json.dumps(self.answers[name]).encode())
        self.listener.drain()
        return [name for name, _ in asked]

    def hear(self, key, payload, *, work=True):
        """Publish a sample, and record it."""
        sample = SimpleNamespace(key_expr=f"hmrsim/{key}", payload=SimpleNamespace(to_bytes=lambda: payload))
        self.link.handlers[self.link.keys.everything()](sample)
        if work:
            self.listener.work(0.0)

    def lose_token(self):
        """Make the simulator unreachable for a moment."""
        self.link.handlers[self.link.keys.alive()](SimpleNamespace(kind=zenoh.SampleKind.DELETE))

    def samples(self):
        """End it; return times in seconds, keys and payloads."""
        self.listener.drain()
        self.file.close()
        return [(round(at / 1e9, 3), key, payload) for at, key, payload in Recording(self.path).samples()]

    def kinds(self):
        """End it; return the kinds of what happened."""
        return [payload["kind"] for _, key, payload in self.samples() if key == "_world/events"]


@pytest.fixture
def heard(tmp_path):
    """Return a listener with the initial state."""
    made = Listening(tmp_path / "run.mcap")
    made.answer()
    yield made
    made.file.close()


GARBAGE = [
    b"[" * 100_000,
    b'{"a":' * 100_000,
    b"",
    b"\xff",
    b"[]",
    b"7",
    b"{}",
    b'{"kind":7,"stamp":{"sec":3,"nanosec":0}}',
    b'{"stamp":{"sec":3,"nanosec":0}}',
    b'{"kind":"reset","stamp":[]}',
    b'{"kind":"reset","stamp":{"sec":1e400,"nanosec":0}}',
    b'{"kind":"reset","stamp":{"sec":1000000000000000000000,"nanosec":0}}',
    b'{"kind":"reset","stamp":{"sec":-3,"nanosec":0.5}}',
    b'{"kind":"status","stamp":{"sec":3,"nanosec":0},"status":[]}',
    b'{"kind":"goal","action":[],"stamp":{"sec":3,"nanosec":0}}',
    b'{"status_list":[{"goal_info":{"goal_id":"x","stamp":{"sec":1e30,"nanosec":0}},"status":1}]}',
]


@pytest.mark.parametrize(
    "key", ["_world/events", "_world/clock", "wall_e/_tree", "wall_e/odom", "wall_e/wait/_action/status"]
)
def test_garbage_of_other_publishers_is_survived(heard, key):
    for payload in GARBAGE:
        with case(payload[:80]):
            heard.hear(key, payload)
            heard.hear("_world/events", json.dumps(RESET).encode())

    assert ["reset"] * len(GARBAGE) == heard.kinds()


@pytest.mark.parametrize("at", ["null", "[]", "7", '{"x":1,"y":2}', '["a","b"]', "[1" + "0" * 400 + ",0]"])
def test_an_item_that_is_put_nowhere_does_no_harm(heard, at):
    """Markers of later events are still written."""
    heard.hear(
        "_world/events", b'{"kind":"placed","item":"parcel","at":%b,"stamp":{"sec":1,"nanosec":0}}' % at.encode()
    )
    heard.hear("_world/events", b'{"kind":"picked","item":"anvil","robot":"eve","stamp":{"sec":2,"nanosec":0}}')

    assert "picked" in heard.kinds()


def test_after_a_loss_everything_is_queried_anew(heard, monkeypatch):
    """The world is queried again after a loss, once few samples wait."""
    monkeypatch.setattr(listener, "_MAX_WAITING", 3)
    monkeypatch.setattr(listener, "_FEW_WAITING", 1)
    for _ in range(4):
        heard.hear("_world/events", json.dumps({**RESET, "kind": "door_closed"}).encode(), work=False)
    heard.listener.work(0.0)
    early = list(heard.link.asked)
    heard.listener.work(0.0)

    assert (1, []) == (heard.listener.lost, early)
    assert ["info", "get_current_world", "scene"] == heard.answer()
    assert 2 == sum(key == "_world/world" for _, key, _ in heard.samples())


def test_a_simulator_that_was_away_for_a_moment_is_asked_anew(heard):
    """The listener queries again, as another simulator may have replaced the first one."""
    heard.lose_token()
    interrupted = heard.listener.interrupted
    heard.listener.query_again()
    heard.answer()

    assert (True, False) == (interrupted, heard.listener.interrupted)
    keys = [(key, payload.get("kind")) for _, key, payload in heard.samples() if key != "_world/info"]
    once = [("_world/world", None), ("_world/scene", None)]
    assert [*once, ("_world/events", "simulator_returned"), *once] == keys


def test_robots_that_come_all_at_once_are_asked_for_once_a_second(heard):
    """The scene is not requested again before the answer arrives."""
    asked = []
    for tenth in range(30):
        event = {**SPAWNED, "stamp": {"sec": tenth // 10 + 2, "nanosec": tenth % 10 * 10**8}}
        heard.hear("_world/events", json.dumps(event).encode())
        if heard.link.asked:
            asked.append(tenth)
            heard.answers["scene"]["stamp"] = event["stamp"]
            heard.answer()

    assert [0, 10, 20] == asked
