"""The record of a run: its goals and the events of its world."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.goal import GoalStatus


@dataclass
class Goal:
    """A goal that was accepted.

    Attributes:
        robot: Who pursues it.
        action: The action's name.
        goal_id: Its id, 32 hex digits.
        goal: The goal message.
        status: Its status.
        accepted: When it was accepted, in simulated seconds.
        ended: When it ended; None while it is under way.
        result: Its result; None while it is under way.
    """

    robot: str
    action: str
    goal_id: str
    goal: Message | None
    status: GoalStatus
    accepted: float
    ended: float | None = None
    result: Message | None = None
    _find: Callable[[], str] | None = field(default=None, repr=False, compare=False)

    @property
    def where(self) -> str:
        """The place at which the robot was when it ended, as `hmrsim.testing.Run.where` says; empty before that."""
        return "" if self._find is None else self._find()


@dataclass(frozen=True)
class Happening:
    """Something that happened in the world.

    Attributes:
        at: When, in simulated seconds.
        kind: Its kind, such as ``door_opened`` or ``deadlock``; docs/reference/report.md and `_world/events` have all.
        fields: The rest of it, as in JSON.
        text: The same in words.
    """

    at: float
    kind: str
    fields: dict[str, Any]
    text: str


class Record(SelectiveSink):
    """A sink that keeps what happens.

    Args:
        place: Returns a function that finds the place at which a robot is now; None where there is none.
    """

    topics = frozenset({Topic.EVENTS})

    def __init__(self, place: Callable[[str], Callable[[], str] | None]) -> None:
        self._place = place
        self.goals: dict[tuple[str, str, str], Goal] = {}
        self._kept: list[GoalChanged | EventStamped] = []

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        handlers: dict[type, Callable[[Any], object]] = {GoalChanged: self._note_goal, EventStamped: self._kept.append}
        return handlers.get(kind)

    def _note_goal(self, output: GoalChanged) -> None:
        self._kept.append(output)
        key, now = (output.robot, output.action, output.goal_id), output.stamp / NANOSECONDS
        goal = self.goals.get(key)
        if goal is None:
            goal = Goal(*key, output.goal, output.status, now)
            self.goals[key] = goal
        goal.status = output.status
        if output.status.terminal:
            goal.ended, goal.result, goal._find = now, output.result, self._place(output.robot)  # noqa: SLF001 - of this module

    def happenings(self, wanted: Callable[[Event], bool]) -> list[Happening]:
        """Return the events that are wanted, in order."""
        return [
            Happening(kept.stamp / NANOSECONDS, event.kind, event.as_dict(), event.describe())
            for kept in self._kept
            if wanted(event := kept.event() if isinstance(kept, GoalChanged) else kept.event)
        ]
