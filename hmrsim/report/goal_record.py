"""Goals of a run and the waits during them, which refer to each other."""

from __future__ import annotations

from collections.abc import Iterable
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
    """A wait of a robot on its way, or in a queue; or a part of one, where what it waits for changes.

    Attributes:
        since: When the whole wait began.
    """

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
    since: int = -1

    def __post_init__(self) -> None:
        """Take it for a whole wait unless another one is said to have begun earlier."""
        if self.since < 0:
            self.since = self.began

    @property
    def length(self) -> int:
        """The nanoseconds that the robot waited."""
        return (self.ended or self.began) - self.began

    @property
    def what(self) -> str:
        """What it waits for, as text."""
        return self.why or ", ".join(self.robots) or "something"


def count_waits(records: Iterable[WaitRecord]) -> int:
    """Return how many waits these records are parts of."""
    return len({(wait.robot, wait.kind, wait.since) for wait in records})
