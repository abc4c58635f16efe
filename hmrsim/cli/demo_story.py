"""The story of a demo's mission: a line for each event, and a summary at the end."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.cli.telling import text_of
from hmrsim.events.goals import GoalStatusChanged
from hmrsim.events.robots import ItemPicked, ItemPlaced, MotionBegan, Stopped
from hmrsim.protocol.goal import GoalStatus

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.geometry import Point

_INSTANT: Final = 1e-6
"""Seconds by which a rounded time may be too early."""

_MARKS: Final = {"SUCCESS": "done", "FAILURE": "failed", "RUNNING": "begun"}


class Line(NamedTuple):
    """One line of the story.

    Attributes:
        sim_time: In simulated seconds; None where it is not known.
        source: ``world`` for the simulator, ``tree`` for the controller.
        hands_over: Whether the robot's next line comes from the other source.
    """

    sim_time: float | None
    source: str
    robot: str
    text: str
    hands_over: bool = False

    def to_json(self) -> dict[str, Any]:
        """Return it as JSON values, the time in whole milliseconds."""
        time = None if self.sim_time is None else round(self.sim_time, 3)
        return {"sim_time": time, "source": self.source, "robot": self.robot, "text": self.text}

    def __str__(self) -> str:
        """Return it as one line of text."""
        time = "" if self.sim_time is None else f"{self.sim_time:.3f}"
        return f"{time:>9} | {self.source:<5} | {self.robot:<8} | {self.text}"


@dataclass
class RobotSum:
    """The account of one robot.

    Attributes:
        succeeded: Goals that succeeded.
        distance: Driven, in the world's unit.
        moved: The items that it has put down.
        carries: The item that it holds.
        does: The running behaviour of its tree, or the last one.
        way: The segments that it drives: for each when it ends, in simulated seconds, and from where to where it leads.
    """

    type: str
    succeeded: int = 0
    failed: int = 0
    distance: float = 0.0
    moved: list[str] = field(default_factory=list)
    carries: str = ""
    does: str = ""
    way: Sequence[tuple[float, Point, Point]] = ()


class Story:
    """Follows a mission.

    Args:
        robots: The type of each robot, by name.
    """

    def __init__(self, robots: dict[str, str]) -> None:
        self.robots = {name: RobotSum(kind) for name, kind in robots.items()}
        self.sim_time = 0.0
        self._trees: dict[str, dict[str, str]] = {name: {} for name in robots}

    def on_event(self, at: float, event: Event) -> Iterator[Line]:
        """Process an event of the simulation and its time; yield the lines to show."""
        self.sim_time = at
        name = event.subject
        ended = False
        if (robot := self.robots.get(name)) is not None:
            ended = _follow(robot, event, at)
        elif getattr(event, "robot", ""):
            # The robot is not part of the mission.
            return
        if text := text_of(event):
            yield Line(at, "world", name, text, hands_over=ended)

    def ticked(self, tree: dict[str, Any]) -> Iterator[Line]:
        """Process a tree of the controller; yield a line for each behaviour that began or ended."""
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
        """Return the summary by robot."""
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


def _follow(robot: RobotSum, event: Event, time: float) -> bool:
    """Record what a robot does at a time; return whether a goal has ended."""
    match event:
        case GoalStatusChanged():
            status = GoalStatus(event.status)
            robot.succeeded += status is GoalStatus.SUCCEEDED
            robot.failed += status.terminal and status is not GoalStatus.SUCCEEDED
            return status.terminal
        case ItemPicked():
            robot.carries = event.item
        case ItemPlaced():
            robot.carries = ""
            robot.moved.append(event.item)
        case MotionBegan():
            robot.distance -= _left(robot.way, time, event.from_[:2])
            robot.way = [*_segments(event, time)]
            robot.distance += math.fsum(math.dist(start, end) for _, start, end in robot.way)
        case Stopped():
            robot.distance -= _left(robot.way, time, event.at)
            robot.way = ()
    return False


def _segments(event: MotionBegan, time: float) -> Iterator[tuple[float, Point, Point]]:
    """Yield the segments of a motion that begins at a time."""
    yield (time := time + event.duration), event.from_[:2], event.to[:2]
    for each in event.then:
        yield (time := time + each["duration"]), tuple(each["from"][:2]), tuple(each["to"][:2])


def _left(way: Sequence[tuple[float, Point, Point]], time: float, at: Point) -> float:
    """Return how much of a way is left for a robot that is somewhere on it at a time."""
    ahead = [(start, end) for ends, start, end in way if ends > time + _INSTANT]
    return math.dist(at, ahead[0][1]) + math.fsum(math.dist(*segment) for segment in ahead[1:]) if ahead else 0.0


def _leaves(nodes: Sequence[dict[str, Any]]) -> Iterator[dict[str, Any]]:
    """Yield the behaviours without children, which are the active ones."""
    for node, after in zip(nodes, (*nodes[1:], {"depth": 0}), strict=True):
        if after["depth"] <= node["depth"]:
            yield node
