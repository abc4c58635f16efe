"""Events as signals: they hold at the instant of the event, and not a nanosecond later."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hmrsim.events import STATUSES, registry
from hmrsim.events.goals import SendGoalRejected
from hmrsim.history.timeline import GoalSeen, Phase
from hmrsim.properties.observing.signal import Signal

if TYPE_CHECKING:
    from hmrsim.events import Event, EventPattern
    from hmrsim.history.timeline import Timeline

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
