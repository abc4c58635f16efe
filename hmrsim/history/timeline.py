"""The time of a run: occurrences in order, alarms between them, and the parts of its state that follow it."""

from __future__ import annotations

import heapq
from collections.abc import Callable, Hashable
from enum import IntEnum
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.engine.sim_time import JITTER
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.events.simulation import SimulationReset, WorldLoaded
from hmrsim.history.occurrence import BatterySeen, SceneSeen

if TYPE_CHECKING:
    from hmrsim.history.occurrence import Occurrence

_SAMPLED: Final = (SceneSeen, BatterySeen)
"""Occurrences that may arrive late, so that they do not indicate a reset of time."""

_UNSET: Final = 1
"""The stamp of time 0, which ROS would read as unset."""

Handler = Callable[[int, Any], object]
"""Takes a time in nanoseconds and the event at that time."""


class GoalSeen(NamedTuple):
    """A change of a goal's status.

    Attributes:
        status: Of action_msgs/msg/GoalStatus.
        cause: The reason for a goal that did not succeed, as an identifier; otherwise empty.
    """

    robot: str
    action: str
    goal_id: str
    status: int
    cause: str


class Phase(IntEnum):
    """When an alarm rings within its instant."""

    CHANGE = 0
    """Before all occurrences of the instant: the state of the world changes."""
    EXPIRY = 1
    """After all occurrences of the instant: a deadline has passed."""


class Alarm:
    """A function that is called at a time, unless the alarm is canceled."""

    __slots__ = ("_call",)

    def __init__(self, call: Callable[[int], object]) -> None:
        self._call: Callable[[int], object] | None = call

    def cancel(self) -> None:
        """Cancel the alarm."""
        self._call = None

    def ring(self, at: int) -> None:
        """Call the function with the time, unless it was canceled."""
        if self._call is not None:
            self._call(at)


class Timeline:
    """Dispatches occurrences to the handlers of their kinds, in order of time; alarms ring in between.

    Time continues after a reset, so all times are nanoseconds since the run began.

    Attributes:
        now: The time of the last occurrence, or alarm.
        began: When the run began; None before it.
        offset: The time of the last reset, which is added to stamps of simulated time.
        handlers: The handlers by the type of event; changes of goals have the type `GoalSeen`.
        restarts: How often simulated time was reset.
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
        """Begin the run at a stamp, unless it has begun; return whether it begins now."""
        if self.began is not None:
            return False
        self.began = self.now = self._latest = 0 if stamp == _UNSET else stamp
        return True

    def on(self, kinds: type | tuple[type, ...], handler: Handler) -> None:
        """Call a handler with each later occurrence of a kind, or of some kinds, after the earlier handlers."""
        for kind in kinds if isinstance(kinds, tuple) else (kinds,):
            self.handlers[kind] = (*self.handlers.get(kind, ()), handler)

    def on_reset(self, scopes: int, call: Callable[[int], object]) -> None:
        """Call a function with the time of each reset with any of some scopes of ResetSimulation, or of a new world."""

        def reset(at: int, event: SimulationReset) -> None:
            if not event.scope or event.scope & scopes:
                call(at)

        self.on(SimulationReset, reset)
        self.on(WorldLoaded, lambda at, _event: call(at))

    def derive_goals(self) -> None:
        """Derive `GoalSeen` from each later event of a goal's status, for sources that have only events."""
        self.on(GoalStatusChanged, self._derive_goal)

    def _derive_goal(self, at: int, event: GoalStatusChanged) -> None:
        seen = GoalSeen(event.robot, event.action, event.goal_id, event.status, event.cause or "")
        for handler in self.handlers.get(GoalSeen, ()):
            handler(at, seen)

    def on_goals_of(self, robot: str, handler: Handler) -> None:
        """Call a handler with each later change of a robot's goals."""
        if not self._of_robots:
            self.on(GoalSeen, self._goal)
        self._of_robots.setdefault(robot, []).append(handler)

    def _goal(self, at: int, goal: GoalSeen) -> None:
        for handler in self._of_robots.get(goal.robot, ()):
            handler(at, goal)

    def alarm(self, at: int, phase: Phase, call: Callable[[int], object]) -> Alarm:
        """Return an alarm that rings at a time, or with the next occurrence if that time has passed."""
        alarm = Alarm(call)
        self._number += 1
        heapq.heappush(self._alarms, (at, phase, self._number, alarm))
        return alarm

    def settle(self, call: Callable[[int], object]) -> None:
        """Call a function once at the end of this instant, with its time."""
        self._unsettled[call] = None

    def take(self, occurrence: Occurrence) -> None:
        """Process an occurrence, and advance time to it."""
        event = occurrence.event
        handlers = self.handlers.get(type(event))
        if handlers is not None:
            self.give(occurrence.at, event, handlers)
        elif not isinstance(event, _SAMPLED):
            self.look(occurrence.at)

    def give(self, stamp: int, event: Any, handlers: tuple[Handler, ...]) -> None:
        """Advance to a stamp and call some handlers."""
        at = (0 if stamp == _UNSET else stamp) + self.offset if isinstance(event, _SAMPLED) else self._look(stamp)
        if at > self.now:
            self.advance(at)
        for handler in handlers:
            handler(self.now, event)

    def look(self, stamp: int) -> None:
        """Process the stamp of an event without handlers: alarms that are due before it ring."""
        at = self._look(stamp)
        if self._alarms and self._alarms[0][0] < at and at > self.now:
            self.advance(at)

    def restart(self, ended: int) -> None:
        """Process a reset of simulated time at a stamp of the time before."""
        at = max(ended + self.offset, self.now)
        self.advance(at)
        self.offset = self._latest = at
        self.restarts += 1

    def _look(self, stamp: int) -> int:
        """Return the time of a stamp since the run began; an earlier stamp than the last one indicates a reset."""
        at = (0 if stamp == _UNSET else stamp) + self.offset
        if at >= self._latest:
            self._latest = at
        elif at < self._latest - JITTER:
            self.offset += self._latest - at
            self.restarts += 1
            at = self._latest
        return at

    def advance(self, at: int) -> None:
        """Advance to a time: alarms that are due before it ring, and each instant that is over is settled."""
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
        """Advance to the end of the run, ring the alarms that are due then, and settle the last instant."""
        until = self._latest if at is None else max(self._latest, at + self.offset)
        if until > self.now:
            self.advance(until)
        self._settle()
        while self._alarms and self._alarms[0][0] <= self.now:
            _, _, _, alarm = heapq.heappop(self._alarms)
            alarm.ring(self.now)
            self._settle()

    def close(self) -> None:
        """End the timeline; it ignores all later occurrences."""
        for left in (self.handlers, self._alarms, self._unsettled):
            left.clear()

    def _settle(self) -> None:
        while self._unsettled:
            calls, self._unsettled = self._unsettled, {}
            for call in calls:
                call(self.now)


class Part:
    """A part of the state, such as that of all doors; watchers follow one member of it by name, or all of them."""

    def __init__(self) -> None:
        self._watchers: dict[Hashable, list[Callable[[], object]]] = {}
        self._watchers_of_all: list[Callable[[Any], object]] = []

    def watch(self, name: Hashable, call: Callable[[], object]) -> None:
        """Call a function after each change of a member."""
        self._watchers.setdefault(name, []).append(call)

    def watch_all(self, call: Callable[[Any], object]) -> None:
        """Call a function with the name of a member after each change of one."""
        self._watchers_of_all.append(call)

    def changed(self, name: Hashable) -> None:
        """Call the watchers of a member."""
        for call in self._watchers.get(name, ()):
            call()
        for call_with in self._watchers_of_all:
            call_with(name)

    def begin_anew(self) -> None:
        """Return to the initial state, as after a reset."""
        raise NotImplementedError
