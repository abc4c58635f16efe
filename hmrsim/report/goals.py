"""The goals of a run and the waits during them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import registry
from hmrsim.history.occurrence import Misfit, text
from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from hmrsim.events.goals import GoalAccepted, GoalStatusChanged, SendGoalRejected
    from hmrsim.geometry import Point
    from hmrsim.history.occurrence import Commanded
    from hmrsim.interfaces.message import Message


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
    """A wait of a robot on its route or in a queue, or the part of a wait in which its cause stays the same.

    Attributes:
        since: The time at which the whole wait began.
        closed: Whether the lane was closed.
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
    closed: bool = False

    def __post_init__(self) -> None:
        """Begin a new wait, unless *since* says that it continues an earlier one."""
        if self.since < 0:
            self.since = self.began

    @property
    def length(self) -> int:
        """The nanoseconds that the robot waited."""
        return (self.ended or self.began) - self.began

    @property
    def what(self) -> str:
        """The reason for the wait, as text."""
        return self.why or ", ".join(self.robots) or "its turn"


def count_waits(records: Iterable[WaitRecord]) -> int:
    """Return how many waits these records are parts of."""
    return len({(wait.robot, wait.kind, wait.since) for wait in records})


_MAX_CHARACTERS: Final = 80
"""Maximum characters of a goal's summary."""


@dataclass(slots=True)
class GoalLog:
    """All goals, in order of acceptance, and the rejected ones, with their times and the active faults."""

    goals: list[GoalRecord] = field(default_factory=list)
    rejected: list[tuple[int, SendGoalRejected, tuple[str, ...]]] = field(default_factory=list)
    _asked: dict[tuple[str, str], Any] = field(default_factory=dict)
    _known: dict[str, GoalRecord] = field(default_factory=dict)

    def ask_of(self, _at: int, event: GoalAccepted) -> None:
        """Record the message of the goal that will be accepted next."""
        self._asked[event.robot, event.action] = event.goal

    def command(self, _at: int, command: Commanded) -> None:
        """Record the message in a line of a trace, if it is a command to send a goal."""
        line = command.line or {}
        if line.get("command") == "send_goal":
            self._asked[text(line, "robot"), text(line, "action")] = line.get("goal")

    def change(self, at: int, event: GoalStatusChanged) -> GoalRecord:
        """Record the status of a goal, and return the goal."""
        robot, action, goal_id, status = event.robot, event.action, event.goal_id, GoalStatus(event.status)
        if status is GoalStatus.UNKNOWN:
            raise Misfit("status is that of no goal")
        goal = self._known.get(goal_id)
        if goal is None or (goal.ended is not None and not status.terminal):
            known = registry().get(action)
            goal = GoalRecord(robot, action, goal_id, at, holds_base=known is None or known.holds_base)
            goal.asked = self._asked.pop((robot, action), None)
            self.goals.append(goal)
            self._known[goal_id] = goal
        goal.status = status
        if status.terminal:
            goal.ended = at
            goal.error_code, goal.error_msg = error_in(event.result)
        return goal


def error_in(result: Any) -> tuple[int | None, str]:
    """Return the error code and message of a result, from the fields of Nav2, MoveIt or the simulation."""
    if not isinstance(result, dict):
        return None, ""
    code, outcome = result.get("error_code", 0), result.get("result")
    message = result.get("error_msg") or ""
    if isinstance(code, dict):
        code, message = code.get("val", 0), message or code.get("message", "")
    elif isinstance(outcome, dict):
        code, message = outcome.get("result", 0), message or outcome.get("error_message", "")
    return (code if isinstance(code, int) else None), message if isinstance(message, str) else ""


@cache
def name_of(action: str, code: int | None) -> str:
    """Return the name of an error code of an action, or of another action that it uses; empty if it has none."""
    known = registry().get(action)
    if known is None or not code:
        return ""
    others = [other for name, other in sorted(registry().items()) if name != action]
    return next(filter(None, (_named(each.result, code) for each in (known, *others))), "")


def _named(result: type[Message], code: int) -> str:
    fields = [each.annotation for each in result.model_fields.values()]
    for kind in (result, *(each for each in fields if isinstance(each, type))):
        names: list[str] = sorted(vars(kind))
        for name in names:
            if name.isupper() and vars(kind)[name] == code:
                return name
    return ""


def target_of(asked: Any) -> tuple[str, Point | None]:
    """Return a summary of a goal, and the first point in it."""
    points = list(_points(asked, 0))
    words = [f"({x:g}, {y:g})" for x, y in points[:3]] + list(_words(asked, 0))[:3]
    summary = ", ".join(words) + (f" and {len(points) - 3} more" if len(points) > 3 else "")  # noqa: PLR2004 - as above
    if len(summary) > _MAX_CHARACTERS:
        summary = f"{summary[:_MAX_CHARACTERS]}…"
    return summary, points[0] if points else None


_MAX_DEPTH: Final = 8


def _points(value: Any, depth: int) -> Iterator[Point]:
    if depth > _MAX_DEPTH:
        return
    if isinstance(value, dict):
        at = value.get("position")
        if isinstance(at, dict):
            x, y = at.get("x", 0.0), at.get("y", 0.0)
            if all(isinstance(each, (int, float)) and abs(each) < 1e300 for each in (x, y)):  # noqa: PLR2004
                yield float(x), float(y)
            return
        for part in value.values():
            yield from _points(part, depth + 1)
    elif isinstance(value, list):
        for part in value:
            yield from _points(part, depth + 1)


_UNSAID: Final = {"header", "position", "orientation", "stamp", "frame_id"}


def _words(value: Any, depth: int, key: str = "") -> Iterator[str]:
    if depth > _MAX_DEPTH:
        return
    if isinstance(value, dict):
        if value.keys() <= {"sec", "nanosec"} and value:
            yield _seconds(value)
            return
        for name, part in value.items():
            if name not in _UNSAID:
                yield from _words(part, depth + 1, name)
    elif isinstance(value, list):
        for part in value:
            yield from _words(part, depth + 1, key)
    elif isinstance(value, str) and value:
        yield value
    elif isinstance(value, (int, float)) and value and not isinstance(value, bool):
        yield f"{key} {value:g}" if abs(value) < 1e300 else key  # noqa: PLR2004


def _seconds(value: Mapping[str, Any]) -> str:
    sec, nanosec = value.get("sec", 0), value.get("nanosec", 0)
    known = all(isinstance(each, int) and abs(each) < 2**63 for each in (sec, nanosec))
    return f"{sec + nanosec / 1e9:g} s" if known else ""
