"""Signals: values that are constant between changes, and events as signals that hold at their instant only."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from hmrsim.events import STATUSES, registry
from hmrsim.events.goals import SendGoalRejected
from hmrsim.history.timeline import GoalSeen, Phase

if TYPE_CHECKING:
    from hmrsim.events import Event, EventPattern
    from hmrsim.history.timeline import Timeline


HOLDS: Final = 1.0
FAILS: Final = -1.0
"""The robustness of what holds, or does not, if there is nothing to measure."""


class Signal:
    """A value that changes at times.

    Attributes:
        value: The robustness of what it says, or what it measures.
    """

    __slots__ = ("_told", "value")

    def __init__(self, value: float = FAILS) -> None:
        self.value = value
        self._told: list[Callable[[], object]] = []

    def set(self, value: float) -> None:
        """Let it have another value from now on."""
        if value != self.value:
            self.value = value
            for told in self._told:
                told()

    def say(self, *, holds: bool) -> None:
        """Let it hold from now on, or not."""
        self.set(HOLDS if holds else FAILS)

    def tell(self, told: Callable[[], object]) -> None:
        """Call a function with each change from now on."""
        self._told.append(told)

    def forget(self, told: Callable[[], object]) -> None:
        """Call it no longer."""
        self._told.remove(told)


Fields = dict[str, Any]
Matched = Callable[[int, Callable[[], Fields]], object]
"""Takes a time, and a function that returns the fields of the event as JSON has them."""


def watch(timeline: Timeline, pattern: EventPattern, matched: Matched) -> None:
    """Call a function with each event that is meant by a pattern."""
    if pattern.goal is not None:
        _watch_goals(timeline, pattern, matched)
        return
    kind = registry()[pattern.event or ""]

    def look(at: int, event: Event) -> None:
        if pattern.matches(event):
            matched(at, event.to_json)

    timeline.on(kind, look)


def _watch_goals(timeline: Timeline, pattern: EventPattern, matched: Matched) -> None:
    def reject(at: int, event: SendGoalRejected) -> None:
        if pattern.matches(event):
            matched(at, event.to_json)

    # As `EventPattern.matches_goal`; this is called for each status of each goal.
    statuses, robot, action = STATUSES[pattern.goal or ""], pattern.robot, pattern.action

    def change(at: int, goal: GoalSeen) -> None:
        if goal.status in statuses and action in (None, goal.action):
            matched(at, goal._asdict)

    if pattern.goal == "rejected":
        timeline.on(SendGoalRejected, reject)
    elif robot is None:
        timeline.on(GoalSeen, change)
    else:
        timeline.on_goals_of(robot, change)


def pulse(timeline: Timeline, pattern: EventPattern) -> Signal:
    """Return a signal that holds at each instant at which an event that is meant comes."""
    signal = Signal()

    def beat(at: int, _fields: Callable[[], Fields]) -> None:
        signal.say(holds=True)
        timeline.alarm(at + 1, Phase.CHANGE, lambda _at: signal.say(holds=False))

    watch(timeline, pattern, beat)
    return signal
