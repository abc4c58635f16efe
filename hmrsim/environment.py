"""Simpy's environment, with what it lacks: time that passes without events, a horizon, and beginning anew."""

from __future__ import annotations

import heapq
import math

import simpy
from simpy.events import URGENT, EventPriority

_LAST = EventPriority(2)
"""Priority of what comes after all else that is due at the same time."""


class Environment(simpy.Environment):
    """The clock and the events of a simulation.

    ``run(until=…)`` would let time pass, too, but leaves a stale event behind, so that the schedule never looks empty.

    Attributes:
        horizon: The last instant of which `take` takes events.
    """

    horizon = math.inf

    def pass_until(self, to: float) -> None:
        """Let it be *to*; nothing may be due before."""
        self._now = to

    def take(self, most: int) -> int:
        """Take at most so many events that are due at the horizon or before; return how many there were."""
        queue, step = self._queue, self.step
        for taken in range(most):
            # The horizon may come nearer with any event.
            if not queue or queue[0][0] > self.horizon:
                return taken
            step()
        return most

    def take_urgent(self) -> None:
        """Let the processes begin that are to begin now, and stop those that are interrupted."""
        while self._queue and self._queue[0][0] <= self._now and self._queue[0][1] == URGENT:
            self.step()

    def schedule_last(self, event: simpy.Event, at: float) -> None:
        """Let an event happen at this time, after all else of that instant."""
        heapq.heappush(self._queue, (at, _LAST, next(self._eid), event))

    def restart(self) -> None:
        """Let it be 0 and forget what was to come; what is due now is due at 0."""
        self._queue[:] = [(0.0, *rest) for at, *rest in self._queue if at <= self._now]  # type: ignore[misc]
        heapq.heapify(self._queue)
        self._now = 0.0


class Tick(simpy.Event):
    """Something that happens at a time, after all else of that instant."""

    def __init__(self, env: Environment, at: float) -> None:
        super().__init__(env)
        self._ok, self._value = True, None
        env.schedule_last(self, at)
