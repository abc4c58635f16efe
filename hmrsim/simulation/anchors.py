"""Anchors: faults that wait for the nth event of a kind, and the events counted so far."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hmrsim.events import registry as events
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.faults import Anchor


@dataclass(slots=True)
class _Waiting:
    """A fault that waits for the *left*-th event of its kind from now on."""

    anchor: Anchor
    came: Callable[[], None]
    left: int


class Anchors:
    """Counts the events that faults wait for; a `Reaction` that wants nothing while none waits.

    Args:
        changed: Called with these anchors when they want other topics than before.
    """

    def __init__(self, changed: Callable[[Anchors], None]) -> None:
        self._changed = changed
        self._waiting: dict[str, dict[str, _Waiting]] = {}

    def add(self, name: str, anchor: Anchor, came: Callable[[], None]) -> None:
        """Call *came* once, in the middle of the instant, when the nth event from now on comes that is meant."""
        new = anchor.kind not in self._waiting
        self._waiting.setdefault(anchor.kind, {})[name] = _Waiting(anchor, came, anchor.nth)
        if new:
            self._changed(self)

    def remove(self, name: str) -> None:
        """Stop the wait of a fault; do nothing if it does not wait."""
        for kind in [kind for kind, waiting in self._waiting.items() if name in waiting]:
            self._drop(kind, name)

    def _drop(self, kind: str, name: str) -> None:
        del self._waiting[kind][name]
        if not self._waiting[kind]:
            del self._waiting[kind]
            self._changed(self)

    @property
    def waits(self) -> bool:
        """Return whether any fault waits for an event."""
        return bool(self._waiting)

    @property
    def topics(self) -> Collection[Topic]:
        """The topics to subscribe to: events, and motions if a fault waits for one."""
        moves = any(not events()[kind].traced for kind in self._waiting)
        return [*(Topic.EVENTS,) * self.waits, *(Topic.MOTION,) * moves]

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self._count if kind in (EventStamped, GoalChanged) else None

    def _count(self, output: GoalChanged | EventStamped) -> None:
        """Count an event for the anchors that match it."""
        kind = GoalStatusChanged.kind if isinstance(output, GoalChanged) else output.kind
        waiting = self._waiting.get(kind, {})
        come = [(name, each) for name, each in waiting.items() if _is_meant(each.anchor, output) and _is_last(each)]
        for name, each in come:
            self._drop(kind, name)
            each.came()


def _is_meant(anchor: Anchor, output: GoalChanged | EventStamped) -> bool:
    if isinstance(output, EventStamped):
        return anchor.matches(output.event)
    if anchor.goal is not None:
        return anchor.matches_goal(output.robot, output.action, output.status)
    return anchor.matches(output.event())


def _is_last(waiting: _Waiting) -> bool:
    waiting.left -= 1
    return waiting.left == 0
