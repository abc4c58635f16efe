"""Simulated time for trees: `now` for nodes, a stand-in for ``time`` in py_trees, and a limit on repetitions.

During a tick, the modules of py_trees that use ``time`` see a stand-in whose clock shows simulated time.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, contextmanager, nullcontext
from contextvars import ContextVar
from typing import Any, Final

from py_trees import decorators, timers

# The modules of py_trees that use ``time``.
_TIMERS: Final[Any] = timers
_DECORATORS: Final[Any] = decorators

NANOSECONDS: Final = 1e9
"""The number of nanoseconds in a second."""

_NOW: Final[ContextVar[float | None]] = ContextVar("simulated time of the tick", default=None)


class _Instant(float):
    """A simulated time in seconds, compared in whole nanoseconds.

    py_trees checks whether the time is later than a deadline (``>``), but trees are ticked exactly at the deadline. So
    an instant also counts as greater than an equal one.
    """

    __slots__ = ()

    def __gt__(self, other: float) -> bool:
        return nanoseconds(self) >= nanoseconds(other)


def now() -> float:
    """Return the simulated time of the current tick in seconds; outside of ticks, Python's monotonic time."""
    known = _NOW.get()
    return time.monotonic() if known is None else known


def reached(deadline: float) -> bool:
    """Return whether a time in seconds has been reached; both are rounded to nanoseconds, as deadlines are sums."""
    return nanoseconds(now()) >= nanoseconds(deadline)


def nanoseconds(seconds: float) -> int:
    """Return a time rounded to nanoseconds, so that sums of seconds that should be equal are equal."""
    return round(seconds * NANOSECONDS)


@contextmanager
def time_behind(seconds: float) -> Iterator[None]:
    """Set the time back by *seconds* while a subtree is ticked that has been suspended for that long."""
    known = _NOW.get()
    with simulated_time(None if known is None else known - seconds):
        yield


def simulated_time(now: float | None) -> AbstractContextManager[None]:
    """Return the context in which trees are ticked at a simulated time; None for Python's own time."""
    # With fractions of nanoseconds, errors would add up, and a timer would miss the instant of its end.
    return nullcontext() if now is None else _SimulatedTime(round(now * NANOSECONDS) / NANOSECONDS)


class _SimulatedTime(AbstractContextManager[None]):
    """Sets the time of nodes during a tick, and stands in for the module ``time`` in py_trees.

    It is not a generator, since every tick enters one and a generator would cost more.
    """

    def __init__(self, now: float) -> None:
        self._now = _Instant(now)

    def time(self) -> float:
        return self._now

    monotonic = time

    def __getattr__(self, name: str) -> Any:
        return getattr(time, name)

    def __enter__(self) -> None:
        stand_in: Any = self
        self._replaced = _TIMERS.time, _DECORATORS.time
        _TIMERS.time = _DECORATORS.time = stand_in
        self._token = _NOW.set(float(self._now))

    def __exit__(self, *_error: object) -> None:
        _NOW.reset(self._token)
        _TIMERS.time, _DECORATORS.time = self._replaced


MAX_TURNS: Final = 1000
"""The maximum number of repetitions of a node in one tick, and at one instant."""


class TurnCounter:
    """Counts how often a node repeats at one instant, to stop endless loops."""

    def __init__(self) -> None:
        self._at = -math.inf
        self._count = 0

    def count(self) -> bool:
        """Count a repetition; return False if there have been more than `MAX_TURNS` since time last advanced."""
        if now() != self._at:
            self._at, self._count = now(), 0
        self._count += 1
        return self._count <= MAX_TURNS
