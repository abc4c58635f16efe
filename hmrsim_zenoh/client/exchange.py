"""The messages between a simulation and its clients in one process: their turns, and who receives what on a key.

Nothing is delivered while the simulation runs: its messages wait until it pauses, and are then delivered in order by
the thread that ran it. So callbacks see the same as over a network, and may send anything.
"""

from __future__ import annotations

import itertools
import logging
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, auto
from functools import partial
from typing import TYPE_CHECKING, Any, Final, Self, TypeVar

import zenoh

from hmrsim_zenoh.client.connection import LOOK

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Inbox

_log = logging.getLogger(__name__)

T = TypeVar("T")


class Delivery:
    """Runs the simulation, and delivers its messages while it pauses.

    Args:
        run: Runs the simulation until it needs a message of the *inbox* to continue.

    Attributes:
        lock: Held by the one thread that runs the simulation, or changes who receives its messages.
    """

    def __init__(self, run: Callable[[], None], inbox: Inbox) -> None:
        self.lock = threading.RLock()
        self._run = run
        self._inbox = inbox
        self._waiting: deque[Callable[[], object]] = deque()
        self._numbers = itertools.count(1)
        self._running = False
        self._settled = threading.Condition()
        self._settling = 0

    def number(self) -> int:
        """Return a number that was not returned before."""
        return next(self._numbers)

    def deliver(self, call: Callable[[T], object], item: T) -> None:
        """Call a function with an item once the simulation pauses."""
        self._waiting.append(partial(call, item))

    def settle(self, *, resume: bool = False) -> None:
        """Run the simulation and deliver the waiting messages until neither has more to do; not while it runs.

        Args:
            resume: Whether to run the simulation even if it has no message to process.
        """
        while True:
            with self.lock:
                if self._running:
                    # A callback of the simulation itself.
                    break
                if resume or self._inbox.waiting:
                    self._running = True
                    try:
                        self._run()
                    finally:
                        self._running = False
            if not self._waiting:
                break
            resume = False
            while self._waiting:
                try:
                    call = self._waiting.popleft()
                except IndexError:
                    # Another thread delivers, too.
                    break
                try:
                    call()
                except Exception:  # noqa: BLE001 - an error in one callback must not stop the others
                    _log.exception("a callback failed")
        if self._settling:
            self.notify()

    def wait_while(self, holds: Callable[[], bool], timeout: float) -> None:
        """Block the calling thread while a condition holds, at most *timeout* wall seconds.

        The condition is evaluated only while the simulation pauses.
        """

        def over() -> bool:
            return not (self._running or holds())

        limit, left = time.monotonic() + timeout, timeout
        with self._settled:
            self._settling += 1
            try:
                while not self._settled.wait_for(over, min(left, LOOK)) and left > 0:
                    left = limit - time.monotonic()
            finally:
                self._settling -= 1

    def notify(self) -> None:
        """Wake the threads in `wait_while`."""
        with self._settled:
            self._settled.notify_all()


class Kind(Enum):
    """The kind of a declaration on a key."""

    __hash__ = object.__hash__
    """Enum's own is written in Python."""

    SUBSCRIBER = auto()
    QUERYABLE = auto()
    TOKEN = auto()
    TOKEN_SUBSCRIBER = auto()


@dataclass(eq=False)
class Declaration:
    """A declaration on a key expression, in force until `undeclare`.

    Attributes:
        call: Receives the messages.
        owner: The connection that declared it.
    """

    exchange: Exchange
    kind: Kind
    key_expr: zenoh.KeyExpr
    call: Callable[[Any], object]
    owner: object

    def undeclare(self) -> None:
        """Withdraw the declaration; a second call has no effect."""
        self.exchange.take_back(self)
        if self.kind is Kind.TOKEN:
            self.exchange.delivery.settle()


class Exchange:
    """The declarations of all connections of a process.

    Attributes:
        delivery: Delivers what is sent; its lock guards the declarations.
        version: Changes with each declaration.
    """

    def __init__(self, delivery: Delivery) -> None:
        self.version = 0
        self.delivery = delivery
        self._declared: dict[Kind, list[Declaration]] = {kind: [] for kind in Kind}
        self._matching: dict[tuple[Kind, str], list[Declaration]] = {}

    def declare(self, kind: Kind, key_expr: str, call: Callable[[Any], object], owner: object) -> Declaration:
        """Add a declaration.

        Raises:
            zenoh.ZError: *key_expr* is not a valid key expression.
        """
        declaration = Declaration(self, kind, zenoh.KeyExpr(key_expr), call, owner)
        with self.delivery.lock:
            self._declared[kind].append(declaration)
            self._note_change(declaration, zenoh.SampleKind.PUT)
        return declaration

    def take_back(self, declaration: Declaration) -> None:
        """Withdraw a declaration, if it is in force."""
        with self.delivery.lock:
            if declaration in self._declared[declaration.kind]:
                self._declared[declaration.kind].remove(declaration)
                self._note_change(declaration, zenoh.SampleKind.DELETE)

    def matching(self, kind: Kind, key_expr: str) -> list[Declaration]:
        """Return the declarations of a kind whose key expressions intersect with one, in order."""
        with self.delivery.lock:
            found = self._matching.get((kind, key_expr))
            if found is None:
                wanted = zenoh.KeyExpr(key_expr)
                found = [each for each in self._declared[kind] if wanted.intersects(each.key_expr)]
                self._matching[kind, key_expr] = found
            return found

    def _note_change(self, declaration: Declaration, change: zenoh.SampleKind) -> None:
        self.version += 1
        self._matching.clear()
        if declaration.kind is Kind.TOKEN:
            key = str(declaration.key_expr)
            for each in self.matching(Kind.TOKEN_SUBSCRIBER, key):
                self.delivery.deliver(each.call, Sample(key, kind=change))


class Payload(bytes):
    """Bytes, as `zenoh.ZBytes` has them."""

    __slots__ = ()

    @classmethod
    def of(cls, payload: Any) -> Self:
        """Return a payload of whatever Zenoh takes as one."""
        return cls(payload.encode() if isinstance(payload, str) else bytes(payload))

    def to_bytes(self) -> bytes:
        """Return it."""
        return self


EMPTY: Final = Payload()


@dataclass(frozen=True, slots=True)
class Sample:
    """A value on a key, an error in reply to a query, or a liveliness token that has come or gone."""

    key_expr: str
    payload: Payload = EMPTY
    encoding: str = ""
    kind: zenoh.SampleKind = field(default_factory=lambda: zenoh.SampleKind.PUT)
    timestamp: str | None = None
    attachment: Payload | None = None


@dataclass(frozen=True, slots=True)
class LocalReply:
    """The reply to a query: a sample or an error."""

    ok: Sample | None = None
    err: Sample | None = None


class Query:
    """A query at one queryable; it ends when it is dropped or garbage-collected.

    Args:
        sent: Its payload, encoding and attachment, as far as it has them.
        on_reply: Takes each reply.
        on_end: Called once, at the end.
    """

    __slots__ = ("_on_end", "_on_reply", "attachment", "encoding", "key_expr", "payload")

    def __init__(
        self, key_expr: str, sent: Mapping[str, Any], on_reply: Callable[[LocalReply], None], on_end: Callable[[], None]
    ) -> None:
        payload, attachment = sent.get("payload"), sent.get("attachment")
        self.key_expr = key_expr
        self.payload = None if payload is None else Payload.of(payload)
        self.attachment = None if attachment is None else Payload.of(attachment)
        self.encoding = str(sent.get("encoding") or "")
        self._on_reply = on_reply
        self._on_end: Callable[[], None] | None = on_end

    def __del__(self) -> None:
        """End the query, as a query of Zenoh does."""
        self.drop()

    def reply(
        self,
        key: object,
        payload: Any,
        *,
        encoding: object = "",
        timestamp: str | None = None,
        attachment: bytes | None = None,
    ) -> None:
        """Send a sample as a reply."""
        attached = None if attachment is None else Payload.of(attachment)
        sample = Sample(str(key), Payload.of(payload), str(encoding), timestamp=timestamp, attachment=attached)
        self._on_reply(LocalReply(ok=sample))

    def reply_err(self, payload: Any, *, encoding: object = "") -> None:
        """Send an error as a reply."""
        self._on_reply(LocalReply(err=Sample(self.key_expr, Payload.of(payload), str(encoding))))

    def drop(self) -> None:
        """End the query; no further replies are sent."""
        on_end, self._on_end = self._on_end, None
        if on_end is not None:
            on_end()
