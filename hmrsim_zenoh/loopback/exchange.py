"""What the sessions of a process have declared, and the delivery of messages among them.

Nothing is delivered while the simulation runs: what it sends waits until time stands, and is delivered then, in order,
in the thread that had it run. So callbacks see what they would see over a network, and may use any session.
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
    """What can be declared."""

    __hash__ = object.__hash__
    """Enum's own is written in Python."""

    SUBSCRIBER = auto()
    QUERYABLE = auto()
    TOKEN = auto()
    TOKEN_SUBSCRIBER = auto()


class Declaration:
    """Something declared on a key expression, until `undeclare`.

    Attributes:
        key_expr: The key expression.
        call: Takes what comes there.
        owner: The session that has declared it.
    """

    def __init__(
        self,
        key_expr: str,
        call: Callable[[Any], object],
        owner: object,
        take_back: Callable[[Declaration], None],
    ) -> None:
        self.key_expr = zenoh.KeyExpr(key_expr)
        self.call = call
        self.owner = owner
        self._take_back = take_back

    def undeclare(self) -> None:
        """Take it back; once more has no effect."""
        self._take_back(self)


class Exchange:
    """The declarations of all sessions of a process, and what waits to be delivered to them.

    Args:
        run: Runs the simulation until it can't go on without a message; it is told whether it has run just before, so
            that only a message could make a difference.

    Attributes:
        version: Changes with each declaration.
    """

    def __init__(self, run: Callable[[bool], None]) -> None:
        self.version = 0
        self._run = run
        self._declared: dict[Kind, list[Declaration]] = {kind: [] for kind in Kind}
        self._matching: dict[tuple[Kind, str], list[Declaration]] = {}
        self._waiting: deque[Callable[[], object]] = deque()
        self._numbers = itertools.count(1)
        # One thread at a time has the simulation run, or changes what is declared.
        self._lock = threading.RLock()
        self._running = False
        self._settled = threading.Condition()
        self._settling = 0

    def number(self) -> int:
        """Return the next number; nobody else gets it."""
        return next(self._numbers)

    def declare(self, kind: Kind, key_expr: str, call: Callable[[Any], object], owner: object) -> Declaration:
        """Declare something.

        Raises:
            zenoh.ZError: *key_expr* is none.
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
        """Call a function with an item as soon as the simulation does not run."""
        self._waiting.append(partial(call, item))

    def settle(self) -> None:
        """Have the simulation run and deliver what waits, until there is no more to do; not while it runs."""
        again = False
        while self._has_run(again=again):
            again = True
            while self._waiting:
                try:
                    call = self._waiting.popleft()
                except IndexError:
                    # Another thread delivers, too.
                    break
                try:
                    call()
                except Exception:  # noqa: BLE001 - whatever a callback raises, the next one is called
                    _log.exception("a callback failed")
        self.notify()

    def wait_while(self, holds: Callable[[], bool]) -> None:
        """Wait in the calling thread while something holds; it is looked at while the simulation does not run."""

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
        """Have the threads that wait look again."""
        if self._settling:
            with self._settled:
                self._settled.notify_all()

    def _has_run(self, *, again: bool) -> bool:
        """Have the simulation run, and return whether that leaves something to deliver."""
        with self._lock:
            if self._running:
                # A callback of the simulation itself.
                return False
            self._running = True
            try:
                self._run(again)
            finally:
                self._running = False
        return bool(self._waiting)

    def _take_back(self, kind: Kind, declaration: Declaration) -> None:
        with self._lock:
            if declaration in self._declared[kind]:
                self._declared[kind].remove(declaration)
                self._note_change()

    def _note_change(self) -> None:
        self.version += 1
        self._matching.clear()
