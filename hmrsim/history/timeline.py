"""The time of a run: occurrences in order, alarms between them, and what is settled at the end of an instant."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from enum import IntEnum
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.engine.sim_time import JITTER
from hmrsim.events.simulation import SimulationReset, WorldLoaded
from hmrsim.history.occurrence import BatterySeen, SceneSeen

if TYPE_CHECKING:
    from hmrsim.history.occurrence import Occurrence

_SAMPLED: Final = (SceneSeen, BatterySeen)
"""Occurrences that may arrive late, so that they do not indicate a reset of time."""

_UNSET: Final = 1
"""The stamp of time 0, which ROS would read as unset."""

Handler = Callable[[int, Any], object]
"""Takes a time in nanoseconds, and what happens then."""


class GoalSeen(NamedTuple):
    """A goal has another status.

    Attributes:
        status: Of action_msgs/msg/GoalStatus.
        cause: Why it did not succeed, as an identifier; empty until then.
    """

    robot: str
    action: str
    goal_id: str
    status: int
    cause: str


class Phase(IntEnum):
    """When an alarm rings within its instant."""

    CHANGE = 0
    """Before all else: the state of the world changes."""
    EXPIRY = 1
    """After all else: what should have happened by then has not."""


class Alarm:
    """Calls a function at a time, unless it was canceled."""

    __slots__ = ("_call",)

    def __init__(self, call: Callable[[int], object]) -> None:
        self._call: Callable[[int], object] | None = call

    def cancel(self) -> None:
        """Do not ring."""
        self._call = None

    def ring(self, at: int) -> None:
        """Call the function with the time, unless it was canceled."""
        if self._call is not None:
            self._call(at)


class Timeline:
    """Gives each occurrence to those that want its kind, in order of time; alarms ring in between.

    Time goes on after a reset, so all times are nanoseconds since the run began.

    Attributes:
        now: The time of the last occurrence, or alarm.
        began: When the run began; None before it.
        offset: Added to stamps of simulated time, which may have begun anew.
        handlers: Who wants what, by the type of the occurrence; `GoalSeen` is that of goals.
        restarts: How often simulated time has begun anew.
    """

    def __init__(self) -> None:
        self.now = 0
        self.restarts = 0
        self.handlers: dict[type, tuple[Handler, ...]] = {}
        self.offset = self._latest = 0
        self._alarms: list[tuple[int, Phase, int, Alarm]] = []
        self._number = 0
        self._unsettled: dict[Callable[[int], object], None] = {}
        self.began: int | None = None
        self._of_robots: dict[str, list[Handler]] = {}

    def begin(self, stamp: int) -> bool:
        """Let the run begin at a stamp, unless it has begun; return whether it has not."""
        if self.began is not None:
            return False
        self.began = self.now = self._latest = 0 if stamp == _UNSET else stamp
        return True

    def on(self, kind: type, handler: Handler) -> None:
        """Call a handler with each occurrence of a kind from now on, after those that were there before."""
        self.handlers[kind] = (*self.handlers.get(kind, ()), handler)

    def on_reset(self, scopes: int, call: Callable[[int], object]) -> None:
        """Call a function with the time of each reset of any of some scopes of ResetSimulation, or of a new world."""

        def reset(at: int, event: SimulationReset) -> None:
            if not event.scope or event.scope & scopes:
                call(at)

        self.on(SimulationReset, reset)
        self.on(WorldLoaded, lambda at, _event: call(at))

    def on_goals_of(self, robot: str, handler: Handler) -> None:
        """Call a handler with the changes of a robot's goals from now on."""
        if not self._of_robots:
            self.on(GoalSeen, self._goal)
        self._of_robots.setdefault(robot, []).append(handler)

    def _goal(self, at: int, goal: GoalSeen) -> None:
        for handler in self._of_robots.get(goal.robot, ()):
            handler(at, goal)

    def alarm(self, at: int, phase: Phase, call: Callable[[int], object]) -> Alarm:
        """Return an alarm that rings at a time, or at once when time goes on if that is over."""
        alarm = Alarm(call)
        self._number += 1
        heapq.heappush(self._alarms, (at, phase, self._number, alarm))
        return alarm

    def settle(self, call: Callable[[int], object]) -> None:
        """Call a function once at the end of this instant, with its time."""
        self._unsettled[call] = None

    def take(self, occurrence: Occurrence) -> None:
        """Give an occurrence to those that want it."""
        event = occurrence.event
        handlers = self.handlers.get(type(event))
        if handlers is not None:
            self.give(occurrence.at, event, handlers)
        elif not isinstance(event, _SAMPLED):
            self.look(occurrence.at)

    def give(self, stamp: int, event: Any, handlers: tuple[Handler, ...]) -> None:
        """Let time go on to a stamp, and call some handlers."""
        at = (0 if stamp == _UNSET else stamp) + self.offset if isinstance(event, _SAMPLED) else self._look(stamp)
        if at > self.now:
            self.advance(at)
        for handler in handlers:
            handler(self.now, event)

    def look(self, stamp: int) -> None:
        """Take note of a stamp of something that nothing wants; what is due before rings."""
        at = self._look(stamp)
        if self._alarms and self._alarms[0][0] < at and at > self.now:
            self.advance(at)

    def restart(self, ended: int) -> None:
        """Take note that simulated time begins anew, at a stamp of the time before."""
        at = max(ended + self.offset, self.now)
        self.advance(at)
        self.offset = self._latest = at
        self.restarts += 1

    def _look(self, stamp: int) -> int:
        """Return the time of a stamp since the run began; one that is earlier than the last begins time anew."""
        at = (0 if stamp == _UNSET else stamp) + self.offset
        if at >= self._latest:
            self._latest = at
        elif at < self._latest - JITTER:
            self.offset += self._latest - at
            self.restarts += 1
            at = self._latest
        return at

    def advance(self, at: int) -> None:
        """Let time go on: what is due before rings, and instants that are over are settled."""
        alarms = self._alarms
        while True:
            if self._unsettled and self.now < at and not self._changes_now():
                # This may set further alarms.
                self._settle()
            elif alarms and (alarms[0][0] < at or (alarms[0][0] == at and alarms[0][1] is Phase.CHANGE)):
                due, _, _, alarm = heapq.heappop(alarms)
                self.now = max(self.now, due)
                alarm.ring(self.now)
            else:
                break
        self.now = at

    def _changes_now(self) -> bool:
        """Return whether a change is due at this instant."""
        alarms = self._alarms
        return bool(alarms) and alarms[0][0] <= self.now and alarms[0][1] is Phase.CHANGE

    def end(self, at: int | None) -> None:
        """Let time go on to the end of the run, and settle its last instant; what is due then rings."""
        until = self._latest if at is None else max(self._latest, at + self.offset)
        if until > self.now:
            self.advance(until)
        self._settle()
        while self._alarms and self._alarms[0][0] <= self.now:
            _, _, _, alarm = heapq.heappop(self._alarms)
            alarm.ring(self.now)
            self._settle()

    def close(self) -> None:
        """Take nothing any more."""
        for left in (self.handlers, self._alarms, self._unsettled):
            left.clear()

    def _settle(self) -> None:
        while self._unsettled:
            calls, self._unsettled = self._unsettled, {}
            for call in calls:
                call(self.now)
