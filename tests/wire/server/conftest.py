"""A served world, and an outside tester: a plain Zenoh client that knows JSON and nothing of hmrsim."""

from __future__ import annotations

import json
import threading
import time
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import pytest
import zenoh

from hmrsim.settings.run import RunSettings
from hmrsim.world import World
from hmrsim.world_checks import world_hash
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.wire.session import SessionOptions
from tests.patience import PATIENCE

from tests.simulation import SMALL_WORLD  # isort: skip

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator


ANY_PORT = ("tcp/127.0.0.1:0",)


@dataclass(frozen=True)
class Reply:
    """One reply, or one sample of a subscription."""

    ok: bool
    key: str
    body: Any
    encoding: str
    at: float = field(default_factory=time.monotonic, compare=False)


def _reply(reply: zenoh.Reply) -> Reply:
    part = reply.ok or reply.err
    text = part.payload.to_string()
    key = str(reply.ok.key_expr) if reply.ok else ""
    # Zenoh itself answers a request that timed out with an error that is no JSON.
    body = json.loads(text) if str(part.encoding).startswith("application/json") else text
    return Reply(reply.ok is not None, key, body, str(part.encoding))


class Heard:
    """Received replies or samples, in order."""

    def __init__(self) -> None:
        self.items: list[Reply] = []
        self._changed = threading.Condition()

    def add(self, item: Reply) -> None:
        with self._changed:
            self.items.append(item)
            self._changed.notify_all()

    def on_reply(self, reply: zenoh.Reply) -> None:
        self.add(_reply(reply))

    def on_sample(self, sample: zenoh.Sample) -> None:
        put = sample.kind == zenoh.SampleKind.PUT
        body = json.loads(sample.payload.to_string()) if put and sample.payload else None
        self.add(Reply(put, str(sample.key_expr), body, str(sample.encoding)))

    @property
    def bodies(self) -> list[Any]:
        return [item.body for item in self.items]

    def wait(self, until: Callable[[list[Any]], bool]) -> list[Any]:
        """Return the messages, once *until* holds for them."""
        with self._changed:
            assert self._changed.wait_for(lambda: until(self.bodies), PATIENCE), self.bodies[-5:]
            return self.bodies

    def wait_for_status(self, goal_id: str, status: int) -> list[Any]:
        """Return the status lists, once a goal has had a status."""
        return self.wait(lambda bodies: any((goal_id, status) in statuses(body) for body in bodies))


def statuses(body: Any) -> list[tuple[str, int]]:
    return [(item["goal_info"]["goal_id"], item["status"]) for item in body["status_list"]]


class Pending:
    """A request whose replies are still to come."""

    def __init__(self, replies: Any) -> None:
        self._replies = replies

    def all(self) -> list[Reply]:
        return [_reply(reply) for reply in self._replies]

    def one(self) -> Any:
        """Return the body of the one reply."""
        (reply,) = self.all()
        return reply.body


class Tester:
    def __init__(self, endpoint: str, prefix: str = "hmrsim") -> None:
        config = zenoh.Config()
        for key, value in {
            "mode": "client",
            "connect/endpoints": [endpoint],
            "scouting/multicast/enabled": False,
        }.items():
            config.insert_json5(key, json.dumps(value))
        self.session = zenoh.open(config)
        self.endpoint = endpoint
        self._prefix = prefix
        self._subscribers: list[Any] = []

    def key(self, key: str) -> str:
        return f"{self._prefix}/{key}"

    def begin(self, key: str, payload: Any = None) -> Pending:
        """Send a query without waiting; bytes are sent unchanged, everything else as JSON."""
        raw = payload if payload is None or isinstance(payload, bytes) else json.dumps(payload).encode()
        return Pending(self.session.get(self.key(key), payload=raw, timeout=PATIENCE))

    def ask(self, key: str, payload: Any = None) -> list[Reply]:
        return self.begin(key, payload).all()

    def one(self, key: str, payload: Any = None) -> Any:
        """Send a query, and return the body of the only reply."""
        return self.begin(key, payload).one()

    def hear(self, *keys: str, into: Heard | None = None) -> Heard:
        """Subscribe to keys; samples are stored in the order in which they arrive."""
        heard = into or Heard()
        handler = zenoh.handlers.Callback(heard.on_sample, indirect=False)
        self._subscribers += [self.session.declare_subscriber(self.key(key), handler) for key in keys]
        return heard

    def send(self, name: str, goal: Any, goal_id: str | None = None) -> Any:
        """Send a goal to ``robot/action``; return the answer."""
        return self.one(f"{name}/_action/send_goal", {"goal": goal} | ({"goal_id": goal_id} if goal_id else {}))

    def result(self, name: str, goal_id: str) -> Any:
        return self.one(f"{name}/_action/get_result", {"goal_id": goal_id})

    def do(self, name: str, goal: Any) -> Any:
        """Send a goal and return its status and result."""
        answer = self.send(name, goal)
        assert answer["accepted"], answer
        return self.result(name, answer["goal_id"])

    def cancel(self, name: str, goal_id: str | None = None, stamp: Any = None) -> Any:
        info = ({"goal_id": goal_id} if goal_id else {}) | ({"stamp": stamp} if stamp else {})
        return self.one(f"{name}/_action/cancel_goal", {"goal_info": info})

    def status(self, name: str) -> list[tuple[str, int]]:
        return statuses(self.one(f"{name}/_action/status"))

    def where(self, robot: str) -> tuple[float, float]:
        position = self.one(f"{robot}/odom")["pose"]["pose"]["position"]
        return position["x"], position["y"]

    def close(self) -> None:
        self.session.close()


def to(x: float, y: float, frame: str = "") -> Any:
    return {"pose": {"header": {"frame_id": frame}, "pose": {"position": {"x": x, "y": y}}}}


def seconds(number: int) -> Any:
    return {"time": {"sec": number}}


class Served:
    """Hosts and the testers connected to them, all closed at the end."""

    def __init__(self) -> None:
        self.hosts: list[Host] = []
        self._testers: list[Tester] = []

    def host(self, world: Any = None, options: SessionOptions | None = None, **settings: Any) -> Host:
        model = World.model_validate(world or SMALL_WORLD)
        loaded: Any = SimpleNamespace(world=model, hash=world_hash(model), warnings=(), path=None)
        self.hosts.append(Host(loaded, options or SessionOptions(listen=ANY_PORT), RunSettings(**settings)))
        return self.hosts[-1]

    def tester(self, host: Host, prefix: str = "hmrsim") -> Tester:
        """Return one more client of a host."""
        self._testers.append(Tester(host.endpoints[0], prefix))
        return self._testers[-1]

    def __call__(self, world: Any = None, **settings: Any) -> Tester:
        host = self.host(world, **settings)
        host.start()
        return self.tester(host)

    def close(self) -> None:
        for tester in self._testers:
            tester.close()
        for host in self.hosts:
            host.stop()


@pytest.fixture
def serve() -> Iterator[Served]:
    """Serve worlds: ``serve(world, real_time_factor=…)`` returns a client."""
    served = Served()
    yield served
    served.close()


@pytest.fixture
def fast(serve: Served) -> Tester:
    """Return a client of the small world at the greatest speed."""
    return serve(real_time_factor=0)


@pytest.fixture
def live(serve: Served) -> Tester:
    """Return a client of the small world in real time, where a wait of 1000 s outlasts every test."""
    return serve(real_time_factor=1.0)


@pytest.fixture(scope="module")
def shared() -> Iterator[Tester]:
    """Return a client that the tests of a module share, because they change nothing in its world."""
    served = Served()
    yield served(real_time_factor=0)
    served.close()


@pytest.fixture(scope="session")
def go() -> Any:
    return to


@pytest.fixture(scope="session")
def wait() -> Any:
    return seconds
