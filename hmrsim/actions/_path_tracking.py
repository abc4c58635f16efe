"""Path tracking by the robot's own pose estimate, as in Nav2's controller server."""

from __future__ import annotations

import math
from itertools import accumulate, pairwise
from typing import TYPE_CHECKING, Any, Final

from hmrsim.geometry import METER, distance, foot, heading, turn

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.geometry import Point
    from hmrsim.robots.robot import Robot

_WINDOW: Final = 2.0
"""How far ahead on the path its nearest point is looked for, beside what the robot may have driven since, in meters."""


class PathTracker:
    """The progress of a robot along a path.

    Args:
        points: Those of the path, of which there is one at least.
    """

    def __init__(self, robot: Robot, points: Sequence[Point]) -> None:
        self._robot = robot
        self._segments = list(pairwise(points)) or [(points[0], points[0])]
        lengths = [distance(a, b) for a, b in self._segments]
        self._driven = [0.0, *accumulate(lengths)]
        self._at = 0
        self._along = 0.0
        self._looked = -math.inf

    def values(self, speed: float) -> dict[str, Any]:
        """Return the plain values of a nav2_msgs/msg/TrackingFeedback."""
        robot = self._robot
        pose = robot.estimated(robot.pose())
        error = self._approach(pose.point)
        a, b = self._segments[self._at]
        stamped = robot.stamped(pose)
        return {
            "header": stamped["header"],
            "position_tracking_error": error,
            "heading_tracking_error": turn(pose.yaw, heading(a, b)) if a != b else 0.0,
            "current_path_index": self._at,
            "robot_pose": stamped,
            "distance_to_goal": distance(pose.point, self._segments[-1][1]),
            "speed": speed,
            "remaining_path_length": self._driven[-1] - self._along,
        }

    def _approach(self, point: Point) -> float:
        """Go on to the point of the path nearest to another one; return how far left of the path that is."""
        window = _WINDOW * METER[self._robot.units] + self._robot.speed * (self._robot.now - self._looked)
        self._looked = self._robot.now
        begin, best = self._along, math.inf
        for number in range(self._at, len(self._segments)):
            if self._driven[number] - begin > window:
                break
            a, b = self._segments[number]
            near = foot(point, a, b)
            away = distance(point, near)
            if away < best:
                best, self._along, self._at = away, self._driven[number] + distance(a, near), number
        a, b = self._segments[self._at]
        left = (b[0] - a[0]) * (point[1] - a[1]) - (b[1] - a[1]) * (point[0] - a[0])
        return best if left >= 0.0 else -best
