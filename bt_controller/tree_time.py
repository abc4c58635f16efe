"""Simulated time for py_trees, whose timers and decorators ask Python's ``time``."""

from __future__ import annotations

import time
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

from py_trees import decorators, timers

if TYPE_CHECKING:
    from collections.abc import Iterator

_TELLING: Final[tuple[Any, ...]] = (timers, decorators)
"""The modules of py_trees that look at ``time``."""

_NANOSECONDS: Final = 1e9


class _Instant(float):
    """A simulated time, of whole nanoseconds.

    py_trees asks whether it is later than a deadline. It is woken at the deadline itself: that is late enough.
    """

    __slots__ = ()

    def __gt__(self, other: float) -> bool:
        return round(self * _NANOSECONDS) >= round(other * _NANOSECONDS)


class _Time:
    """Stands where py_trees has the module ``time``."""

    def __init__(self, now: float) -> None:
        self._now = _Instant(now)

    def time(self) -> float:
        return self._now

    monotonic = time

    def __getattr__(self, name: str) -> Any:
        return getattr(time, name)


@contextmanager
def simulated_time(now: float | None) -> Iterator[None]:
    """Let py_trees tell this time; its own where nobody knows the simulated one."""
    if now is None:
        yield
        return
    stand_in: Any = _Time(now)
    others = [module.time for module in _TELLING]
    for module in _TELLING:
        module.time = stand_in
    try:
        yield
    finally:
        for module, other in zip(_TELLING, others, strict=True):
            module.time = other
