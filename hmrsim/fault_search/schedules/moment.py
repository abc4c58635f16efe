"""What happens in a run that a thing of a schedule may be anchored to."""

from __future__ import annotations

from typing import Any, NamedTuple


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

    def anchor(self, after: float = 0.0) -> dict[str, Any]:
        """Return the anchor for it, in plain values; *after* is in simulated seconds."""
        said: dict[str, Any] = {"goal": self.goal} if self.goal else {"event": self.event}
        said |= {"robot": self.robot} if self.robot else {}
        said |= {"action": self.action} if self.action else {}
        said |= {"nth": self.nth} if self.nth > 1 else {}
        return said | ({"after": after} if after else {})
