"""Poses and paths: how far a robot is along one, what is left of it, parts of it.

Paths here have a pose where they bend, not one each few centimetres as Nav2's have. So what Nav2's documentation says
of the pose of a path that is closest to the robot is meant of its closest point.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

from hmrsim.geometry import between, distance, foot, turn, yaw_of
from hmrsim.interfaces.geometry_msgs import Point as PointMessage
from hmrsim.interfaces.geometry_msgs import Pose, PoseStamped
from hmrsim.interfaces.nav_msgs import Path

if TYPE_CHECKING:
    from hmrsim.geometry import Point


def point_of(at: PoseStamped) -> Point:
    """Return where a pose is."""
    return at.pose.position.x, at.pose.position.y


def yaw_at(at: PoseStamped) -> float:
    """Return which way a pose faces, in radians."""
    return yaw_of(at.pose.orientation.z, at.pose.orientation.w)


def apart(a: PoseStamped, b: PoseStamped) -> float:
    """Return how far two poses are from each other, in the world's unit of length."""
    return distance(point_of(a), point_of(b))


def length_of(path: Path) -> float:
    """Return how long a path is, in the world's unit of length."""
    return math.fsum(apart(a, b) for a, b in pairwise(path.poses))


class Trail:
    """A path, and the robot's progress along it, from which the search for the closest point may start."""

    def __init__(self) -> None:
        self._path: Path | None = None
        self._reached = 0.0

    def reached(self, path: Path, at: PoseStamped, *, ahead: float = math.inf, weight: float = 0.0) -> float:
        """Return how far along a path its point is that is closest to a pose; the first of several.

        Args:
            path: The path, which has poses.
            at: The pose.
            ahead: How far to look along the path from the last point that was found on it; infinite for all of it.
            weight: What a radian between the pose and the path's poses counts as, in the world's unit of length.
        """
        begin = self._reached if math.isfinite(ahead) and path == self._path else 0.0
        self._path, self._reached = path, _closest(path, at, begin, begin + ahead, weight)
        return self._reached


def _closest(path: Path, at: PoseStamped, begin: float, end: float, weight: float) -> float:
    """Return how far along a path, from *begin* to *end*, is what is closest to a pose."""
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
    """Return a path's part between two distances along it; nothing is added to its ends."""
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
    """Return the one pose of a path at a distance along it; none of a path without poses."""
    before = 0.0
    for a, b in pairwise(path.poses):
        after = before + apart(a, b)
        if along < after:
            return [_on(a, b, along - before)]
        before = after
    return path.poses[-1:]


def _on(a: PoseStamped, b: PoseStamped, how_far: float) -> PoseStamped:
    """Return the pose at a distance from *a* on the way to *b*; it has the orientation of *a*."""
    if how_far <= 0.0:
        return a
    x, y = between(point_of(a), point_of(b), how_far / apart(a, b))
    return PoseStamped(header=a.header, pose=Pose(position=PointMessage(x=x, y=y), orientation=a.pose.orientation))
