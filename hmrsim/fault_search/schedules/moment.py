"""What happens in a run that a thing of a schedule may be anchored to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from collections.abc import Mapping

What = tuple[str, str, str, str, int]
"""The change of a goal, the kind of event, the robot, the action, and which one of them."""


class Moment(NamedTuple):
    """The nth change of a goal, or the nth event of a kind.

    Attributes:
        at: When, in simulated seconds.
        goal: What became of a goal; empty for an event.
        event: The kind of event; empty for a goal.
        robot: The robot that it is about; empty for none.
        action: The goal's action; empty for an event.
        nth: Which one of them, from 1.
        lasted: Of a goal that has ended: how long it was executed, in simulated seconds.
    """

    at: float
    goal: str
    event: str
    robot: str
    action: str
    nth: int
    lasted: float = 0.0

    @property
    def what(self) -> What:
        """What happens, whenever."""
        return self[1:6]

    def anchor(self, after: float = 0.0) -> dict[str, Any]:
        """Return the anchor for it, in plain values; *after* is in simulated seconds."""
        said: dict[str, Any] = {"goal": self.goal} if self.goal else {"event": self.event}
        said |= {"robot": self.robot} if self.robot else {}
        said |= {"action": self.action} if self.action else {}
        said |= {"nth": self.nth} if self.nth > 1 else {}
        return said | ({"after": after} if after else {})


def anchored_to(anchor: Mapping[str, Any]) -> What:
    """Return the moment that an anchor is for, in whatever run."""
    goal, event, robot, action = (str(anchor.get(field, "")) for field in ("goal", "event", "robot", "action"))
    return goal, event, robot, action, anchor.get("nth", 1)
