"""How simulated time follows the wall: the only reader of a wall clock in the simulation.

Commands are taken from the inbox between events and stamped with the simulated time of that moment. When the
machine can't keep up, time lags behind the wall and says so; it never leaps.
"""

from __future__ import annotations

import math
import time
from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from hmrsim.gateway import ForgetResult, GoalChanged, Topic

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.gateway import Event, Inbox
    from hmrsim.simulator import Simulator

_EVENTS_BETWEEN_POLLS = 16
"""Events that are taken between two looks into the inbox: a look costs little, an event a microsecond or more."""

_BETWEEN_WARNINGS = 5.0
"""Wall seconds from one word about lag to the next."""

_QUANTUM = 0.005
"""Wall seconds from one round of events to the next, where they are many: to wake, and to send a message that goes
alone, costs more than to do the work. What is due in between comes as much late, a command never."""

_MOST_LATE = 0.1
"""Wall seconds that an event may be late before time gives up catching up."""


class Retention:
    """A sink that remembers when goals ended by the wall clock, so that their results are dropped in time.

    Args:
        timeout: Wall seconds that a result is kept; negative for ever.
    """

    def __init__(self, timeout: float) -> None:
        self._timeout = timeout
        self._ended: deque[tuple[float, ForgetResult]] = deque()

    def emit(self, event: Event) -> None:
        """Take note of a goal that has ended."""
        if self._timeout >= 0 and isinstance(event, GoalChanged) and event.status.terminal:
            forget = ForgetResult(event.robot, event.action, event.goal_id)
            self._ended.append((time.monotonic() + self._timeout, forget))

    def wants(self, _topic: Topic) -> bool:
        """Return False: goals' ends come unasked."""
        return False

    def apply(self, simulator: Simulator) -> None:
        """Submit the commands that drop what is out of date."""
        while self._ended and self._ended[0][0] <= time.monotonic():
            simulator.submit(self._ended.popleft()[1])


@dataclass
class Pacing:
    """Runs a simulator at a pace until its inbox is closed.

    Attributes:
        simulator: What to run.
        inbox: Where commands come from.
        retention: Drops old results.
        real_time_factor: Simulated seconds a wall second; 0 for as fast as possible.
        duration: Simulated seconds after which to end.
        on_lag: Told how many wall seconds time has lost in all, when it loses some; not more often than every 5 s.
        lag: Wall seconds that time has lost.
    """

    simulator: Simulator
    inbox: Inbox
    retention: Retention
    real_time_factor: float = 1.0
    duration: float = math.inf
    on_lag: Callable[[float], None] = lambda _lag: None
    lag: float = 0.0
    _told: float = field(default=-math.inf, init=False)

    def run(self) -> None:
        """Run until the inbox is closed or the duration is over; goals that run then are left to `Simulator.stop`."""
        if self.real_time_factor > 0:
            self._run_paced(self.real_time_factor)
        else:
            self._run_free()

    def _take_command(self) -> bool:
        """Submit the next command in the inbox; return whether there was one.

        Only one: the next may come of its answer, and is later than this one.
        """
        command = self.inbox.poll()
        if command is None:
            return False
        self.retention.apply(self.simulator)
        self.simulator.submit(command)
        return True

    def _run_free(self) -> None:
        simulator = self.simulator
        while not self.inbox.closed:
            # Neither keeps the other waiting: so many commands at most, then so many events.
            taken = 0
            while taken < _EVENTS_BETWEEN_POLLS and self._take_command():
                taken += 1
            if not taken and simulator.next_event == math.inf:
                simulator.settle()
                self.inbox.wait(None)
                continue
            if self.duration < simulator.next_event < math.inf:
                simulator.advance(self.duration)
                return
            simulator.take(self.duration, _EVENTS_BETWEEN_POLLS, idle=False)

    def _run_paced(self, factor: float) -> None:
        simulator = self.simulator
        anchor = time.monotonic() - simulator.now / factor
        while True:
            woken = time.monotonic()
            target = min((woken - anchor) * factor, self.duration)
            late = (target - simulator.next_due) / factor
            if late > _MOST_LATE:
                anchor += late
                target -= late * factor
                self._lose(late)
            if self.inbox.closed:
                # Whatever ends now ends at this time, not at that of the event before.
                if simulator.next_due > target:
                    simulator.advance(max(target, simulator.now))
                return
            if simulator.next_due <= target:
                # Some of it: commands are looked for in between.
                simulator.take(target, _EVENTS_BETWEEN_POLLS)
            elif target >= self.duration:
                simulator.advance(self.duration)
                return
            if self.inbox.waiting:
                self._take_waiting(target)
            elif simulator.next_due > target:
                wake = max(min(simulator.next_due, self.duration) / factor + anchor, woken + _QUANTUM)
                self.inbox.wait(None if wake == math.inf else max(0.0, wake - time.monotonic()))

    def _lose(self, seconds: float) -> None:
        """Count wall seconds that time lags, and tell, but not every time."""
        self.lag += seconds
        now = time.monotonic()
        if now - self._told >= _BETWEEN_WARNINGS:
            self._told = now
            self.on_lag(self.lag)

    def _take_waiting(self, target: float) -> None:
        """Submit the next command at the time of its arrival; when time lags, some commands at the time that it is.

        What is overdue does not come before them all, as there may be no end to it.
        """
        if self.simulator.next_due > target:
            self.simulator.advance(max(target, self.simulator.now))
            self._take_command()
            return
        for _ in range(_EVENTS_BETWEEN_POLLS):
            if not self._take_command():
                return
