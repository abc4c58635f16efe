"""Goals of a run and the waits during them, which refer to each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from hmrsim.geometry import Point


@dataclass(slots=True, eq=False)
class GoalRecord:
    """A goal and its progress; times in nanoseconds."""

    robot: str
    action: str
    goal_id: str
    accepted: int
    asked: Any = None
    status: GoalStatus = GoalStatus.ACCEPTED
    ended: int | None = None
    error_code: int | None = None
    error_msg: str = ""
    distance: float = 0.0
    waited: int = 0
    waits: int = 0
    reroutes: int = 0
    deadlock: bool = False
    waiting: WaitRecord | None = None
    holds_base: bool = True
    faults: tuple[str, ...] = ()


@dataclass(slots=True)
class WaitRecord:
    """A wait of a robot on its way, or in a queue."""

    robot: str
    began: int
    kind: str
    robots: tuple[str, ...] = ()
    why: str = ""
    lane: tuple[str, str] | None = None
    at: Point | None = None
    goal: GoalRecord | None = None
    ended: int | None = None
    until: str = ""

    @property
    def length(self) -> int:
        """The nanoseconds that the robot waited."""
        return (self.ended or self.began) - self.began

    @property
    def what(self) -> str:
        """What it waits for, as text."""
        return self.why or ", ".join(self.robots) or "something"
