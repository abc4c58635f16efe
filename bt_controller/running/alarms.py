"""Conditions for which a simulator in lockstep stops time, so that no tree has to be ticked in between."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bt_controller.core.topics import Topics
    from hmrsim_zenoh.client.conditions import Condition
    from hmrsim_zenoh.client.lockstep import Lockstep
    from hmrsim_zenoh.errors import RequestError


class Alarms:
    """What each tree waits for.

    Args:
        lockstep: Has conditions watched.
        topics: Learns which can't be.
        wake: Called with a tree's name when a condition of its own is met, or can't be watched.
    """

    def __init__(self, lockstep: Lockstep, topics: Topics, wake: Callable[[str], None]) -> None:
        self._lockstep = lockstep
        self._topics = topics
        self._wake = wake
        self._waiting: dict[str, dict[Condition, Callable[[], None]]] = {}

    def set(self, name: str, conditions: Iterable[Condition]) -> None:
        """Wake a tree for these conditions and no others; the simulator is told with the next advance."""
        waiting = self._waiting.setdefault(name, {})
        wanted = dict.fromkeys(conditions)
        for needless in [condition for condition in waiting if condition not in wanted]:
            waiting.pop(needless)()
        for condition in wanted:
            if condition not in waiting:
                waiting[condition] = self._lockstep.watch(condition, partial(self._end, name, condition))

    def clear(self) -> None:
        """Wake no tree; after a reset they wait for something else."""
        for name in self._waiting:
            self.set(name, ())

    def _end(self, name: str, condition: Condition, error: RequestError | None) -> None:
        self._waiting[name].pop(condition, None)
        if error is not None:
            self._topics.poll(condition.key)
        self._wake(name)
