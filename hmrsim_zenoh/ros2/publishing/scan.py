"""Laser scans of the walls of a world."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING, Any, Final

from hmrsim.geometry import METER
from hmrsim.interfaces.message import unbuilt
from hmrsim.interfaces.sensor_msgs import LaserScan

if TYPE_CHECKING:
    from hmrsim.geometry import Pose
    from hmrsim.world.model import World

RAYS: Final = 180
"""Rays of a scan, all around: one for every 2 degrees."""
_STEP: Final = math.tau / RAYS
_DIRECTIONS: Final = [(math.cos(i * _STEP - math.pi), math.sin(i * _STEP - math.pi)) for i in range(RAYS)]
_RANGE: Final = 10.0
"""The longest range in meters; a ray that meets no wall up to there is infinite, as in ROS."""
_LEAST_RANGE: Final = 0.02


class Scanner:
    """Measures the distances from a robot to the walls of a world; doors, items and robots are invisible."""

    def __init__(self, world: World) -> None:
        self.world = world
        meter = METER[world.units]
        self._range, self._least = _RANGE * meter, _LEAST_RANGE * meter
        self._segments = [(*a, *b) for outline in world.outlines for a, b in pairwise(outline)]

    def ranges(self, pose: Pose) -> list[float]:
        """Return the distances along all rays, from behind the robot counterclockwise, in the world's unit."""
        x, y, reach = pose.x, pose.y, self._range
        cos, sin = math.cos(pose.yaw), math.sin(pose.yaw)
        left, right, low, high = x - reach, x + reach, y - reach, y + reach
        ranges = [math.inf] * RAYS
        for ax, ay, bx, by in self._segments:
            if (
                (ax < left and bx < left)
                or (ax > right and bx > right)
                or (ay < low and by < low)
                or (ay > high and by > high)
            ):
                continue
            # In the robot's frame, the ray at an angle meets the line at cross / (direction x wall).
            px, py = (ax - x) * cos + (ay - y) * sin, (ay - y) * cos - (ax - x) * sin
            qx, qy = (bx - x) * cos + (by - y) * sin, (by - y) * cos - (bx - x) * sin
            cross = px * qy - py * qx
            if cross < 0.0:
                # Counterclockwise, as seen from the robot.
                px, py, qx, qy, cross = qx, qy, px, py, -cross
            wx, wy = qx - px, qy - py
            first = math.ceil((math.atan2(py, px) + math.pi) / _STEP)
            last = math.floor((math.atan2(qy, qx) + math.pi) / _STEP)
            if last < first - 1:
                last += RAYS
            for i in range(first, last + 1):
                ray = i % RAYS
                dx, dy = _DIRECTIONS[ray]
                across = dx * wy - dy * wx
                if across > 0.0 and (distance := cross / across) < ranges[ray]:
                    ranges[ray] = distance
        return [distance if distance <= reach else math.inf for distance in ranges]

    def message(self, pose: Pose, header: dict[str, Any]) -> dict[str, Any]:
        """Return the scan of a robot as a LaserScan.

        Args:
            pose: Where the robot is.
            header: The time, and the frame of the scan.
        """
        return unbuilt(
            LaserScan,
            header=header,
            angle_min=-math.pi,
            angle_max=math.pi - _STEP,
            angle_increment=_STEP,
            range_min=self._least,
            range_max=self._range,
            ranges=self.ranges(pose),
        )
