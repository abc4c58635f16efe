"""What a mission's events and trees tell: lines as it goes, and the sum at the end."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.cli.goal_summary import error_in
from hmrsim.cli.telling import words_for
from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

_SECOND: Final = 1e-9
_MARKS: Final = {"SUCCESS": "done", "FAILURE": "failed", "RUNNING": "begun"}


class Line(NamedTuple):
    """One thing that happened.

    Attributes:
        sim_time: When, in simulated seconds; None where it is not known.
        source: ``world`` for what the simulator says, ``tree`` for what the controller does.
        robot: Whose.
        text: What.
        hands_over: Whether what comes next of this robot comes from the other source.
    """

    sim_time: float | None
    source: str
    robot: str
    text: str
    hands_over: bool = False

    def to_json(self) -> dict[str, Any]:
        """Return it for programs, the time in whole milliseconds."""
        time = None if self.sim_time is None else round(self.sim_time, 3)
        return {"sim_time": time, "source": self.source, "robot": self.robot, "text": self.text}

    def __str__(self) -> str:
        """Return it as one line of a log."""
        time = "" if self.sim_time is None else f"{self.sim_time:.3f}"
        return f"{time:>9} | {self.source:<5} | {self.robot:<8} | {self.text}"


@dataclass
class RobotSum:
    """What one robot has done.

    Attributes:
        type: Its type.
        succeeded: Goals that succeeded.
        failed: Goals that ended otherwise.
        distance: Driven, in the world's unit.
        moved: The items that it has put down somewhere.
        carries: The item that it holds.
        does: The behaviour of its tree that runs, or the last that did.
        target: Where the piece that it drives ends.
    """

    type: str
    succeeded: int = 0
    failed: int = 0
    distance: float = 0.0
    moved: list[str] = field(default_factory=list)
    carries: str = ""
    does: str = ""
    target: tuple[float, float] = (0.0, 0.0)


class Story:
    """Follows a mission.

    Args:
        robots: The type of each robot, by name.
    """

    def __init__(self, robots: dict[str, str]) -> None:
        self.robots = {name: RobotSum(kind) for name, kind in robots.items()}
        self.sim_time = 0.0
        self._trees: dict[str, dict[str, str]] = {name: {} for name in robots}

    def happened(self, event: dict[str, Any]) -> Iterator[Line]:
        """Take an event of ``_world/events``; yield what people want to know."""
        stamp = event["stamp"]
        self.sim_time = stamp["sec"] + stamp["nanosec"] * _SECOND
        told = words_for(event)
        if told:
            yield Line(self.sim_time, "world", event.get("robot") or "", told)
        robot = self.robots.get(event.get("robot", ""))
        if robot is None:
            return
        text = ""
        ended = False
        match event["kind"]:
            case "status":
                ended = GoalStatus(event["status"]).terminal
                text = _goal_change(robot, event)
            case "picked":
                robot.carries = event["item"]
                text = f"picked up {event['item']}"
            case "placed":
                robot.carries = ""
                robot.moved.append(event["item"])
                text = f"put {event['item']} down at {_point(event['at'])}"
            case "motion":
                robot.target = (event["to"][0], event["to"][1])
                robot.distance += math.dist(event["from"][:2], robot.target)
            case "stopped":
                robot.distance -= math.dist(event["at"], robot.target)
        if text:
            yield Line(self.sim_time, "world", event["robot"], text, hands_over=ended)

    def ticked(self, tree: dict[str, Any]) -> Iterator[Line]:
        """Take a tree as the controller shows it; yield which behaviours began and ended."""
        robot = self.robots.get(tree.get("robot", ""))
        if robot is None:
            return
        before = self._trees[tree["robot"]]
        nodes = tree["nodes"]
        for node in _leaves(nodes):
            name, status = node["name"], node["status"]
            if status == "RUNNING":
                robot.does = name
            if before.get(name) != status and status in _MARKS:
                message = f": {node['message']}" if status == "FAILURE" and node["message"] else ""
                text = f"{name} {_MARKS[status]}{message}"
                yield Line(tree["sim_time"], "tree", tree["robot"], text, hands_over=status == "RUNNING")
            before[name] = status
        if tree["status"] in ("SUCCESS", "FAILURE"):
            robot.does = f"mission {_MARKS[tree['status']]}"

    def to_json(self) -> dict[str, Any]:
        """Return the sum by robot."""
        return {
            name: {
                "type": robot.type,
                "succeeded": robot.succeeded,
                "failed": robot.failed,
                "distance": round(robot.distance, 3),
                "items_moved": robot.moved,
            }
            for name, robot in self.robots.items()
        }


def _goal_change(robot: RobotSum, event: dict[str, Any]) -> str:
    """Count a goal that has ended; return what is worth telling."""
    status = GoalStatus(event["status"])
    if not status.terminal:
        return f"{event['action']} accepted" if status is GoalStatus.ACCEPTED else ""
    if status is GoalStatus.SUCCEEDED:
        robot.succeeded += 1
        return f"{event['action']} {status.name}"
    robot.failed += 1
    why = error_in(event.get("result", {}))
    return f"{event['action']} {status.name}{f': {why}' if why else ''}"


def _leaves(nodes: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the behaviours that have no children, which are those that do something."""
    for node, after in zip(nodes, (*nodes[1:], {"depth": 0}), strict=True):
        if after["depth"] <= node["depth"]:
            yield node


def _point(at: Sequence[float]) -> str:
    return f"({at[0]:g}, {at[1]:g})"
