"""The cost of security: encrypted sessions with access control, against open ones."""

from __future__ import annotations

import operator
import threading
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, Final

import zenoh

from benchmarks._fleet import grid_world
from benchmarks._processes import PATIENCE, child
from benchmarks._report import Row
from benchmarks._timing import Variant, interleaved, microseconds
from benchmarks._wire import GoalSender, served
from hmrsim.settings.run import RunSettings
from hmrsim_zenoh.security.keystore import Keystore, Network, own_hosts
from hmrsim_zenoh.wire.enclave import SIMULATOR, Member
from hmrsim_zenoh.wire.options import SessionOptions
from hmrsim_zenoh.wire.session import open_client, open_server

if TYPE_CHECKING:
    from multiprocessing.connection import Connection

    from benchmarks._processes import Child

QUICK: dict[str, Any] = {"rounds": 10, "messages": 1_000}

_TOPIC: Final = "hmrsim/bench/odom"
_SIZES: Final = (500, 50_000)
"""Bytes of a message: those of an odometry, and of a large scene."""
_KINDS: Final = ("open", "secured")


def run(*, rounds: int = 200, messages: int = 20_000) -> list[Row]:
    """Return wall times and messages a second, side by side in one run."""
    with ExitStack() as stack:
        path = Path(stack.enter_context(TemporaryDirectory())) / "keys"
        members = [Member(SIMULATOR, SIMULATOR), Member("operator", "operator")]
        Keystore.create(path, members, Network(hosts=own_hosts()))
        keystores = {"open": None, "secured": path}
        return [*_requests(stack, keystores, rounds), *_topics(stack, keystores, messages, rounds)]


def _requests(stack: ExitStack, keystores: dict[str, Path | None], rounds: int) -> list[Row]:
    """Return the rows of connecting, of goals and of their results."""
    world, settings = grid_world(1, side=4), RunSettings(real_time_factor=0, keep_results=10)
    there = {kind: stack.enter_context(served(world, settings, secure=keystores[kind])) for kind in _KINDS}
    robot = next(iter(world.robots))

    def connect(kind: str) -> None:
        with there[kind].session():
            pass

    senders = {kind: GoalSender(stack.enter_context(there[kind].session()), f"{robot}/wait") for kind in _KINDS}
    return [
        *_compared("connecting", {kind: partial(connect, kind) for kind in _KINDS}, rounds),
        *_compared("send_goal to accepted", {kind: senders[kind].accepted for kind in _KINDS}, rounds),
        *_compared("goal to result", {kind: senders[kind].right_behind for kind in _KINDS}, rounds),
    ]


def _compared(what: str, calls: dict[str, Any], rounds: int) -> list[Row]:
    took = interleaved([Variant(kind, call) for kind, call in calls.items()], rounds)
    return [
        Row(f"{what}, {kind}", took.spread(kind, microseconds), "µs", took.ratio(kind, to="open")) for kind in _KINDS
    ]


def _topics(stack: ExitStack, keystores: dict[str, Path | None], messages: int, rounds: int) -> list[Row]:
    """Return the rows of the messages that a subscriber receives a second."""
    rows = []
    for size in _SIZES:
        count = max(messages * _SIZES[0] // size, 10)
        rate = partial(operator.truediv, count)
        streams = {kind: _Stream.opened(stack, keystores[kind]) for kind in _KINDS}
        calls = {kind: partial(streams[kind].send, count, size) for kind in _KINDS}
        took = interleaved([Variant(kind, call) for kind, call in calls.items()], max(rounds // 10, 1))
        rows += [
            Row(f"topic of {size:,} bytes, {kind}", took.spread(kind, rate), "messages/s", took.ratio(kind, to="open"))
            for kind in _KINDS
        ]
    return rows


@dataclass
class _Stream:
    """A publisher in a separate process, and a subscriber in this one."""

    publisher: Child
    come: threading.Semaphore

    @classmethod
    def opened(cls, stack: ExitStack, secure: Path | None) -> _Stream:
        """Start the process, and subscribe."""
        options = SessionOptions(listen=(f"{'tls' if secure else 'tcp'}/127.0.0.1:0",), secure=secure)
        publisher = stack.enter_context(child(_publish, options))
        endpoint = publisher.receive()
        session = stack.enter_context(open_client(SessionOptions(connect=(endpoint,), secure=secure)))
        come = threading.Semaphore(0)
        session.declare_subscriber(_TOPIC, lambda _sample: come.release())
        found = cls(publisher, come)
        found.send(1, 1)
        return found

    def send(self, count: int, size: int) -> None:
        """Return when as many messages have come.

        Raises:
            RuntimeError: One of them has not come.
        """
        self.publisher.ask((count, size))
        for _ in range(count):
            if not self.come.acquire(timeout=PATIENCE):
                raise RuntimeError(f"{_TOPIC}: a message was lost")


def _publish(pipe: Connection, options: SessionOptions) -> None:
    """Publish as many messages of a size as asked for, once there is a subscriber."""
    session, endpoints = open_server(options)
    with session:
        publisher = session.declare_publisher(_TOPIC, congestion_control=zenoh.CongestionControl.BLOCK)
        heard = threading.Event()
        publisher.declare_matching_listener(lambda status: heard.set() if status.matching else None)
        pipe.send(endpoints[0])
        while (order := _order(pipe)) is not None:
            count, size = order
            pipe.send("begun")
            heard.wait(PATIENCE)
            payload = bytes(size)
            for _ in range(count):
                publisher.put(payload)


def _order(pipe: Connection) -> tuple[int, int] | None:
    try:
        found: tuple[int, int] = pipe.recv()
    except EOFError:
        return None
    return found
