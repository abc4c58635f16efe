"""Signals: values that stay constant between changes; an event is a signal that holds only at its instant."""

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
"""The robustness of a condition that holds or fails, if it has no measure."""


class Signal:
    """A value that stays constant until it is set.

    Attributes:
        value: The robustness of a condition, or a measured value.
    """

    __slots__ = ("_subscribers", "value")

    def __init__(self, value: float = FAILS) -> None:
        self.value = value
        self._subscribers: list[Callable[[], object]] = []

    def set(self, value: float) -> None:
        """Set the value; call the subscribers if it differs."""
        if value != self.value:
            self.value = value
            for on_change in self._subscribers:
                on_change()

    def subscribe(self, on_change: Callable[[], object]) -> None:
        """Call a function after each change from now on."""
        self._subscribers.append(on_change)

    def unsubscribe(self, on_change: Callable[[], object]) -> None:
        """Stop calling a subscribed function."""
        self._subscribers.remove(on_change)


Matched = Callable[[int, "Event | GoalSeen"], object]
"""A function of a time, and of the event or the change of a goal's status."""


def fields_of(event: Event | GoalSeen) -> dict[str, Any]:
    """Return the fields of an event or of the change of a goal's status, as in JSON."""
    return event._asdict() if isinstance(event, GoalSeen) else event.to_json()


def watch(timeline: Timeline, pattern: EventPattern, matched: Matched) -> None:
    """Call a function with each event that matches a pattern."""
    if pattern.goal is not None:
        _watch_goals(timeline, pattern, matched)
        return
    kind = registry()[pattern.event or ""]

    def look(at: int, event: Event) -> None:
        if pattern.matches(event):
            matched(at, event)

    timeline.on(kind, look)


def _watch_goals(timeline: Timeline, pattern: EventPattern, matched: Matched) -> None:
    def reject(at: int, event: SendGoalRejected) -> None:
        if pattern.matches(event):
            matched(at, event)

    # As `EventPattern.matches_goal`; this is called for each status of each goal.
    statuses, robot, action = STATUSES[pattern.goal or ""], pattern.robot, pattern.action

    def change(at: int, goal: GoalSeen) -> None:
        if goal.status in statuses and action in (None, goal.action):
            matched(at, goal)

    if pattern.goal == "rejected":
        timeline.on(SendGoalRejected, reject)
    elif robot is None:
        timeline.on(GoalSeen, change)
    else:
        timeline.on_goals_of(robot, change)


def pulse(timeline: Timeline, pattern: EventPattern) -> Signal:
    """Return a signal that holds at each instant with an event that matches a pattern."""
    signal = Signal()

    def beat(at: int, _event: Event | GoalSeen) -> None:
        signal.set(HOLDS)
        timeline.alarm(at + 1, Phase.CHANGE, lambda _at: signal.set(FAILS))

    watch(timeline, pattern, beat)
    return signal
