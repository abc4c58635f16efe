"""Simulated time for trees: `now` for nodes, ``time`` for py_trees' timers, and a limit of turns at an instant."""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from typing import Any, Final

from py_trees import decorators, timers

_TIMERS: Final[Any] = timers
_DECORATORS: Final[Any] = decorators
"""The modules of py_trees that use ``time``."""

NANOSECONDS: Final = 1e9
"""In a second."""

_NOW: Final[ContextVar[float | None]] = ContextVar("simulated time of the tick", default=None)


class _Instant(float):
    """A simulated time, of whole nanoseconds.

    py_trees asks whether it is later than a deadline. It is woken at the deadline itself: that is late enough.
    """

    __slots__ = ()

    def __gt__(self, other: float) -> bool:
        return nanoseconds(self) >= nanoseconds(other)


def now() -> float:
    """Return the simulated seconds of the current tick; Python's own time outside of ticks."""
    known = _NOW.get()
    return time.monotonic() if known is None else known


def reached(deadline: float) -> bool:
    """Return whether a time is reached, to the nanosecond: deadlines are sums, while clocks count nanoseconds."""
    return nanoseconds(now()) >= nanoseconds(deadline)


def nanoseconds(seconds: float) -> int:
    """Return a time in whole nanoseconds, in which equal sums of seconds compare equal."""
    return round(seconds * NANOSECONDS)


@contextmanager
def time_behind(seconds: float) -> Iterator[None]:
    """Tick with an earlier time: time stood still for a suspended subtree."""
    known = _NOW.get()
    with simulated_time(None if known is None else known - seconds):
        yield


def simulated_time(now: float | None) -> AbstractContextManager[None]:
    """Tick trees at this simulated time; None means Python's own time."""
    # Fractions of nanoseconds would accumulate, so that a timer would miss the instant of its end.
    return nullcontext() if now is None else _SimulatedTime(round(now * NANOSECONDS) / NANOSECONDS)


class _SimulatedTime(AbstractContextManager[None]):
    """The time of this package's nodes, and of py_trees in place of ``time``; for every tick, so no generator."""

    def __init__(self, now: float) -> None:
        self._now = _Instant(now)

    def time(self) -> float:
        return self._now

    monotonic = time

    def __getattr__(self, name: str) -> Any:
        return getattr(time, name)

    def __enter__(self) -> None:
        stand_in: Any = self
        self._others = _TIMERS.time, _DECORATORS.time
        _TIMERS.time = _DECORATORS.time = stand_in
        self._token = _NOW.set(float(self._now))

    def __exit__(self, *_error: object) -> None:
        _NOW.reset(self._token)
        _TIMERS.time, _DECORATORS.time = self._others


MAX_TURNS: Final = 1000
"""The largest number of repetitions in one tick, and at one instant."""


class TurnCounter:
    """Counts repetitions at one instant."""

    def __init__(self) -> None:
        self._at = -math.inf
        self._count = 0

    def count(self) -> bool:
        """Count a repetition; return whether it is allowed, which after a thousand it is when time has advanced."""
        if now() != self._at:
            self._at, self._count = now(), 0
        self._count += 1
        return self._count <= MAX_TURNS
