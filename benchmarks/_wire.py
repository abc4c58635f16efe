"""A world served by a separate process, and clients with as little overhead as Python allows."""

from __future__ import annotations

import json
import uuid
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import zenoh

from benchmarks._fleet import Wanderers, loaded, plan_everything
from benchmarks._processes import Child, child, wait_for_end
from hmrsim.cli.replay import TraceFile
from hmrsim.program.memory import collect_rarely
from hmrsim_zenoh.hosting.host import Host
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client

if TYPE_CHECKING:
    from multiprocessing.connection import Connection
    from pathlib import Path

    from hmrsim.protocol.sinks import Sink
    from hmrsim.settings.run import RunSettings
    from hmrsim.world.model import World
    from hmrsim_zenoh.ros2.wires import Wire

BARE = "bare/query"
BARE_PAYLOAD = b"x" * 200
"""About what a goal or a result has; the queryable sends it back."""

_TIMEOUT = 30.0
_MADE_AT_ONCE = 1_000
_SUCCEEDED, _CANCELED = 4, 5
_BEGINNING = 2.0
"""Simulated seconds until all robots are on their way."""
_LOOK = 0.05


@dataclass(frozen=True)
class Served:
    """A world that is served by another process.

    Attributes:
        child: The process.
        endpoint: Where to connect.
        secure: The keystore of the sessions; None where they are open.
    """

    child: Child
    endpoint: str
    secure: Path | None = None

    @contextmanager
    def session(self) -> Iterator[zenoh.Session]:
        """Open a session that is connected to the world."""
        with open_client(SessionOptions(connect=(self.endpoint,), secure=self.secure)) as session:
            yield session


@contextmanager
def served(
    world: World,
    settings: RunSettings,
    *,
    wandering: int | None = None,
    trace: Path | None = None,
    wires: Sequence[Wire] = (),
    secure: Path | None = None,
) -> Iterator[Served]:
    """Serve a world and a bare queryable on the same session.

    Args:
        world: The world.
        settings: How to serve it.
        wandering: How many robots, the last ones, never rest; the ways to all waypoints are found before then, as
            they are for 0. None leaves everything as it is in a new world.
        trace: Where to write a trace, as ``--trace`` does.
        wires: The wires of ROS 2 that are spoken.
        secure: A keystore, for encrypted sessions.
    """
    options = SessionOptions(listen=(f"{'tls' if secure else 'tcp'}/127.0.0.1:0",), secure=secure)
    with child(_serve, world, settings, wandering, trace, wires, options) as process:
        yield Served(process, process.receive(), secure)


def _serve(
    pipe: Connection,
    world: World,
    settings: RunSettings,
    wandering: int | None,
    trace: Path | None,
    wires: Sequence[Wire],
    options: SessionOptions,
) -> None:
    written, crowd = TraceFile(trace, world, settings), Wanderers(world)
    sinks: list[Sink] = [*written.sinks, *([crowd] if wandering else [])]
    with (
        Host(loaded(world), options, settings, wires=wires, sinks=sinks, on_wait=[written.flush]) as host,
        written.opened(host.simulator),
    ):
        bare: zenoh.handlers.Callback[zenoh.Query] = zenoh.handlers.Callback(
            lambda query: query.reply(query.key_expr, query.payload), indirect=False
        )
        host._session.declare_queryable(BARE, bare)  # noqa: SLF001 - it must share the simulator's session
        if wandering is not None:
            plan_everything(host.simulator)
        if wandering:
            crowd.start(host.simulator, list(host.simulator.robots)[-wandering:])
        collect_rarely()
        host.start()
        while wandering and host.simulator.now < _BEGINNING:
            if host.wait(_LOOK):
                raise RuntimeError("the simulation died") from host.error
        pipe.send(host.endpoints[0])
        wait_for_end(pipe)


def ask(session: zenoh.Session, key: str, payload: bytes) -> bytes:
    """Send a query, wait for its first reply, and return what it says."""
    return answer(session.get(key, payload=payload, timeout=_TIMEOUT), key)


def answer(replies: Any, key: str) -> bytes:
    """Return what the first of a query's replies says, when it has come.

    Raises:
        RuntimeError: It is an error.
    """
    reply = replies.recv()
    if reply.ok is None:
        raise RuntimeError(f"{key}: {reply.err.payload.to_string()}")
    return bytes(reply.ok.payload.to_bytes())


@dataclass
class GoalSender:
    """Sends goals to one robot's action by bare keys, with generated ids.

    Attributes:
        session: An open session.
        action: Robot and action, as in keys.
        goal: The goal, as JSON values.
    """

    session: zenoh.Session
    action: str
    goal: dict[str, Any] = field(default_factory=dict)
    _requests: list[tuple[bytes, bytes]] = field(default_factory=list)
    _get_result: bytes = b""

    def accepted(self) -> None:
        """Send the goal, and return when it is accepted."""
        self._accepted(ask(self.session, self._key("send_goal"), self._next_goal()))

    def result(self, status: int = _SUCCEEDED) -> None:
        """Return when the goal that was sent last has ended, which it has to with this status."""
        payload = ask(self.session, self._key("get_result"), self._get_result)
        if json.loads(payload)["status"] != status:
            raise RuntimeError(f"{self.action}: {payload!r}")

    def canceled(self) -> None:
        """Send the goal; when it is accepted, cancel it, and return with its result."""
        self.accepted()
        ask(self.session, self._key("cancel_goal"), b'{"goal_info": %b}' % self._get_result)
        self.result(_CANCELED)

    def one_by_one(self) -> None:
        """Send the goal; when it is accepted, ask for the result, and return with it."""
        self.accepted()
        self.result()

    def right_behind(self) -> None:
        """Send the goal and ask for its result at once, and return with it."""
        key = self._key("send_goal")
        sent = self.session.get(key, payload=self._next_goal(), timeout=_TIMEOUT)
        self.result()
        self._accepted(answer(sent, key))

    def execute(self) -> None:
        """Execute the goal with one query, and return with its result."""
        payload = ask(self.session, self._key("execute"), self._next_goal())
        if json.loads(payload).get("status") != _SUCCEEDED:
            raise RuntimeError(f"{self.action}: {payload!r}")

    def _key(self, verb: str) -> str:
        return f"hmrsim/{self.action}/_action/{verb}"

    def _next_goal(self) -> bytes:
        """Return the next request; they are made many at once, so that few are made while the time is taken."""
        if not self._requests:
            ids = [uuid.uuid4().hex for _ in range(_MADE_AT_ONCE)]
            self._requests = [
                (json.dumps({"goal_id": id_, "goal": self.goal}).encode(), json.dumps({"goal_id": id_}).encode())
                for id_ in ids
            ]
        send_goal, self._get_result = self._requests.pop()
        return send_goal

    def _accepted(self, payload: bytes) -> None:
        if not json.loads(payload)["accepted"]:
            raise RuntimeError(f"{self.action}: {payload!r}")
