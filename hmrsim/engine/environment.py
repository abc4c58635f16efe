"""Simpy's environment, with what it lacks: time that passes without events, a horizon, and beginning anew."""

from __future__ import annotations

import heapq
import math
from typing import TYPE_CHECKING, Final

import simpy
from simpy.events import NORMAL, URGENT, EventPriority

if TYPE_CHECKING:
    from collections.abc import Callable

_LAST = EventPriority(2)
"""Priority of what comes after all else that is due at the same time."""

_NOBODY: Final[list[Callable[[simpy.Event], None]]] = []
"""The callbacks of a timeout that was abandoned, which is known by them."""


class Environment(simpy.Environment):
    """The clock and the events of a simulation.

    ``run(until=…)`` would let time pass, too, but leaves a stale event behind, so that the schedule never looks empty.

    Attributes:
        horizon: The last instant of which `take` takes events.
    """

    horizon = math.inf
    _abandoned = 0
    """How many events are in the schedule that nobody waits for any more."""
    _background = 0
    """How many are there for whose sake time does not go on."""

    @property
    def idle(self) -> bool:
        """Whether nothing is scheduled but what happens only if time goes on anyway."""
        return len(self._queue) == self._abandoned + self._background

    def alarm(self, delay: float, ring: Callable[[], None]) -> Alarm:
        """Have *ring* called after a delay, if time goes on that far for other reasons; the alarm can be put off.

        What would wear out by itself, such as a battery that nobody uses, would otherwise keep a simulation running
        in which nothing happens any more.
        """
        alarm = Alarm(self, ring)
        self._background += 1
        self.schedule(alarm, NORMAL, delay)
        return alarm

    def put_off(self, alarm: Alarm) -> None:
        """Forget an alarm; nothing happens if it has rung."""
        if alarm.callbacks is not None and alarm.callbacks is not _NOBODY:
            alarm.callbacks = _NOBODY
            self._background -= 1
            self._abandoned += 1

    def pass_until(self, to: float) -> None:
        """Let it be *to*; nothing may be due before."""
        self._now = to

    def take(self, most: int, *, idle: bool = True) -> int:
        """Take at most so many events that are due at the horizon or before; return how many there were.

        Unless *idle*, none is taken once nothing is scheduled any more for whose sake time goes on.
        """
        queue, step = self._queue, self.step
        for taken in range(most):
            if self._abandoned:
                self._clear()
            # The horizon may come nearer with any event.
            if not queue or queue[0][0] > self.horizon:
                return taken
            if self._background and not idle and self.idle:
                return taken
            step()
        return most

    def peek(self) -> float:
        """Return when the next event is due that somebody waits for; infinite when there is none."""
        if self._abandoned:
            self._clear()
        return super().peek()

    def abandon(self, timeout: simpy.Timeout) -> None:
        """Forget a timeout that nobody waits for any more: time does not go on for its sake."""
        timeout.callbacks = _NOBODY
        self._abandoned += 1

    def soon(self, call: Callable[[], None]) -> None:
        """Have something called at this instant, before all else that is due."""
        event = simpy.Event(self)
        event._ok, event._value = True, None  # noqa: SLF001 - as simpy's own events do
        event.callbacks = [lambda _event: call()]
        self.schedule(event, URGENT)

    def _clear(self) -> None:
        """Take what was abandoned from the top of the schedule; what is below it stays until it comes up."""
        queue = self._queue
        while queue and queue[0][3].callbacks is _NOBODY:
            heapq.heappop(queue)
            self._abandoned -= 1

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
        self._abandoned = sum(event.callbacks is _NOBODY for *_, event in self._queue)
        self._background = sum(isinstance(event, Alarm) and event.callbacks is not _NOBODY for *_, event in self._queue)
        self._now = 0.0


class Tick(simpy.Event):
    """Something that happens at a time, after all else of that instant."""

    def __init__(self, env: Environment, at: float) -> None:
        super().__init__(env)
        self._ok, self._value = True, None
        env.schedule_last(self, at)


class Alarm(simpy.Event):
    """Something that happens at a time if time goes on until then, but for whose sake it does not go on."""

    def __init__(self, env: Environment, ring: Callable[[], None]) -> None:
        super().__init__(env)
        self._ok, self._value = True, None

        def rings(_event: simpy.Event) -> None:
            env._background -= 1  # noqa: SLF001 - the other half of `Environment.alarm`
            ring()

        self.callbacks = [rings]
