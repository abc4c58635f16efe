"""The robot's pose, the goals of a tree, and the geometry of poses and paths, for nodes of several families.

Paths have a pose at each bend, while Nav2's have one every few centimeters. So the closest pose of a path in Nav2's
documentation corresponds to the closest point here.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Final

from py_trees.blackboard import Blackboard

from bt_controller.core.node import EACH_PERIOD, Node
from bt_controller.core.ports import POSE, POSES, STRING, input_port
from hmrsim.geometry import between, distance, foot, turn, yaw_of
from hmrsim.interfaces.geometry_msgs import Point as PointMessage
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped
from hmrsim.interfaces.nav_msgs import Path

if TYPE_CHECKING:
    from bt_controller.core.ports import Port
    from bt_controller.core.robots import Topics
    from hmrsim.geometry import Point
    from hmrsim.interfaces.nav_msgs import Odometry


def point_of(at: PoseStamped) -> Point:
    """Return the position of a pose."""
    return at.pose.position.x, at.pose.position.y


def yaw_at(at: PoseStamped) -> float:
    """Return the yaw of a pose in radians."""
    return yaw_of(at.pose.orientation.z, at.pose.orientation.w)


def apart(a: PoseStamped, b: PoseStamped) -> float:
    """Return the distance between two poses, in the world's unit of length."""
    return distance(point_of(a), point_of(b))


def length_of(path: Path) -> float:
    """Return the length of a path, in the world's unit of length."""
    return math.fsum(apart(a, b) for a, b in pairwise(path.poses))


class Trail:
    """A path and the robot's progress along it, from which the search for the closest point may start."""

    def __init__(self) -> None:
        self._path: Path | None = None
        self._reached = 0.0

    def reached(self, path: Path, at: PoseStamped, *, ahead: float = math.inf, weight: float = 0.0) -> float:
        """Return the distance along a path of its point closest to a pose; the first of several.

        Args:
            path: The path, which has poses.
            at: The pose.
            ahead: The search distance along the path from the previous result; infinite for the whole path.
            weight: The cost of a radian between the pose and the path's poses, in the world's unit of length.
        """
        begin = self._reached if math.isfinite(ahead) and path == self._path else 0.0
        self._path, self._reached = path, _closest(path, at, begin, begin + ahead, weight)
        return self._reached


def _closest(path: Path, at: PoseStamped, begin: float, end: float, weight: float) -> float:
    """Return the distance along a path of the point closest to a pose between *begin* and *end*."""
    best, nearest = begin, math.inf
    before = 0.0
    for a, b in pairwise(path.poses):
        after = before + apart(a, b)
        if after > before and after >= begin and before <= end:
            start, stop = (
                between(point_of(a), point_of(b), (limit - before) / (after - before)) for limit in (begin, end)
            )
            point = foot(point_of(at), start, stop)
            off = math.hypot(distance(point_of(at), point), weight * turn(yaw_at(at), yaw_at(a)) if weight else 0.0)
            if off < nearest:
                best, nearest = before + distance(point_of(a), point), off
        before = after
    return best


def part_of(path: Path, begin: float, end: float) -> Path:
    """Return the part of a path between two distances along it; the path is not extended."""
    poses: list[PoseStamped] = []
    before = 0.0
    for a, b in pairwise(path.poses):
        after = before + apart(a, b)
        if after > begin and before < end:
            if not poses:
                poses.append(_on(a, b, begin - before))
            poses.append(_on(a, b, end - before) if end < after else b)
        before = after
    return Path(header=path.header, poses=poses or [*_point_at(path, begin)])


def _point_at(path: Path, along: float) -> list[PoseStamped]:
    """Return a list with the pose at a distance along a path; empty for a path without poses."""
    before = 0.0
    for a, b in pairwise(path.poses):
        after = before + apart(a, b)
        if along < after:
            return [_on(a, b, along - before)]
        before = after
    return path.poses[-1:]


def _on(a: PoseStamped, b: PoseStamped, how_far: float) -> PoseStamped:
    """Return the pose at a distance from *a* towards *b*, with the orientation of *a*."""
    if how_far <= 0.0:
        return a
    x, y = between(point_of(a), point_of(b), how_far / apart(a, b))
    return PoseStamped(header=a.header, pose=Pose(position=PointMessage(x=x, y=y), orientation=a.pose.orientation))


GLOBAL_FRAME: Final[Port] = input_port(STRING, "Ignored: all poses are in the map frame", required=False)
BASE_FRAME: Final[Port] = input_port(STRING, "Ignored: a robot's pose is that of its base", required=False)


class Located(Node):
    """A node that reads its robot's pose."""

    def setup(self, **kwargs: Any) -> None:
        """Watch the topic of the robot's odometry.

        Raises:
            NotServed: The robot has gone.
            PortError: A port's value in the file is invalid.
        """
        super().setup(**kwargs)
        self._topics: Topics = kwargs["topics"]
        self._robots_name: str = kwargs["robot"]
        self._topics.watch(self._robots_name, "odom")

    def next_tick_time(self) -> float:
        """Return that the pose has to be polled."""
        return EACH_PERIOD

    @property
    def odometry(self) -> Odometry:
        """The robot's odometry: its pose and velocity."""
        latest: Odometry = self._topics.latest(self._robots_name, "odom")
        return latest

    @property
    def here(self) -> PoseStamped:
        """The robot's pose in the map frame."""
        odometry = self.odometry
        return PoseStamped(header=odometry.header, pose=odometry.pose.pose)


GOAL_PORTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "goal": input_port(POSE, "Destination", default="{goal}", required=False),
        "goals": input_port(POSES, "Destinations in order", default="{goals}", required=False),
    }
)


def goals_of(node: Node) -> tuple[Any, Any]:
    """Return the values of a node's ports ``goal`` and ``goals``; None for a missing one."""
    return node.read("goal"), node.read("goals")


class Watching(Node):
    """A node that detects writes to the entry of its port ``entry`` since its last check."""

    KEYS: ClassVar = ("entry",)

    _seen = 0

    def updated(self) -> bool:
        """Return whether the entry was written, even with the same value; at first, since the start of the tree."""
        key = self._get_blackboard_key("entry")
        if key not in Blackboard.storage:
            return False
        before, self._seen = self._seen, Blackboard.storage.writes[key]  # type: ignore[attr-defined]  # `Entries`
        return before != self._seen
