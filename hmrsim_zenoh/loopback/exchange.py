"""The declarations of the sessions of a process, and the delivery of messages among them.

Nothing is delivered while the simulation runs: its messages wait until it pauses, and are then delivered in order by
the thread that ran it. So callbacks see the same as over a network, and may use any session.
"""

from __future__ import annotations

import itertools
import logging
import threading
from collections import deque
from collections.abc import Callable
from enum import Enum, auto
from functools import partial
from typing import Any, TypeVar

import zenoh

_log = logging.getLogger(__name__)

T = TypeVar("T")


class Kind(Enum):
    """A kind of declaration of a session."""

    __hash__ = object.__hash__
    """Enum's own is written in Python."""

    SUBSCRIBER = auto()
    QUERYABLE = auto()
    TOKEN = auto()
    TOKEN_SUBSCRIBER = auto()


class Declaration:
    """A declaration on a key expression, in force until `undeclare`.

    Attributes:
        key_expr: The key expression.
        call: Receives the messages.
        owner: The session that declared it.
    """

    def __init__(
        self,
        key_expr: str,
        call: Callable[[Any], object],
        owner: object,
        take_back: Callable[[Declaration], bool],
    ) -> None:
        self.key_expr = zenoh.KeyExpr(key_expr)
        self.call = call
        self.owner = owner
        self._take_back = take_back

    def undeclare(self) -> bool:
        """Withdraw the declaration; return whether it was in force."""
        return self._take_back(self)


class Exchange:
    """The declarations of all sessions of a process, and the messages that wait for delivery.

    Args:
        run: Runs the simulation until it needs a message to continue.
        has_messages: Returns whether the simulation has a message to process.

    Attributes:
        version: Changes with each declaration.
    """

    def __init__(self, run: Callable[[], None], has_messages: Callable[[], bool]) -> None:
        self.version = 0
        self._run = run
        self._has_messages = has_messages
        self._declared: dict[Kind, list[Declaration]] = {kind: [] for kind in Kind}
        self._matching: dict[tuple[Kind, str], list[Declaration]] = {}
        self._waiting: deque[Callable[[], object]] = deque()
        self._numbers = itertools.count(1)
        # One thread at a time runs the simulation or changes the declarations.
        self._lock = threading.RLock()
        self._running = False
        self._settled = threading.Condition()
        self._settling = 0

    def number(self) -> int:
        """Return a number that is unique within the exchange."""
        return next(self._numbers)

    def declare(self, kind: Kind, key_expr: str, call: Callable[[Any], object], owner: object) -> Declaration:
        """Add a declaration.

        Raises:
            zenoh.ZError: *key_expr* is not a valid key expression.
        """
        declaration = Declaration(key_expr, call, owner, partial(self._take_back, kind))
        with self._lock:
            self._declared[kind].append(declaration)
            self._note_change()
        return declaration

    def matching(self, kind: Kind, key_expr: str) -> list[Declaration]:
        """Return the declarations of a kind whose key expressions intersect with one, in order."""
        with self._lock:
            found = self._matching.get((kind, key_expr))
            if found is None:
                wanted = zenoh.KeyExpr(key_expr)
                found = [each for each in self._declared[kind] if wanted.intersects(each.key_expr)]
                self._matching[kind, key_expr] = found
            return found

    def deliver(self, call: Callable[[T], object], item: T) -> None:
        """Call a function with an item once the simulation pauses."""
        self._waiting.append(partial(call, item))

    def settle(self, *, resume: bool = False) -> None:
        """Run the simulation and deliver the waiting messages until neither has more to do; not while it runs.

        Args:
            resume: Whether to run the simulation even if it has no message to process.
        """
        while True:
            with self._lock:
                if self._running:
                    # A callback of the simulation itself.
                    break
                if resume or self._has_messages():
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

    def wait_while(self, holds: Callable[[], bool]) -> None:
        """Block the calling thread while a condition holds; it is evaluated only while the simulation pauses."""

        def over() -> bool:
            return not (self._running or holds())

        if over():
            return
        with self._settled:
            self._settling += 1
            try:
                self._settled.wait_for(over)
            finally:
                self._settling -= 1

    def notify(self) -> None:
        """Wake the threads in `wait_while`."""
        with self._settled:
            self._settled.notify_all()

    def _take_back(self, kind: Kind, declaration: Declaration) -> bool:
        with self._lock:
            found = declaration in self._declared[kind]
            if found:
                self._declared[kind].remove(declaration)
                self._note_change()
            return found

    def _note_change(self) -> None:
        self.version += 1
        self._matching.clear()
