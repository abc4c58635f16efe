"""Scans measure what each ray meets first."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.geometry import Pose
from hmrsim.world.model import World
from hmrsim_zenoh.ros2.publishing.scan import RAYS, Scanner
from tests.profiles import examples
from tests.simulation import SMALL_WORLD

SEGMENTS = [((12, 0), (12, 10)), ((6, 4), (8, 4)), ((8, 4), (8, 6)), ((8, 6), (6, 6)), ((6, 6), (6, 4))]
"""The walls of the small world."""


def first_hit(pose, ray):
    """Return the distance along a ray, by the intersection with each segment."""
    angle = pose.yaw - math.pi + ray * math.tau / RAYS
    dx, dy = math.cos(angle), math.sin(angle)
    hits = [math.inf]
    for (ax, ay), (bx, by) in SEGMENTS:
        wx, wy = bx - ax, by - ay
        if across := dx * wy - dy * wx:
            along = ((ax - pose.x) * wy - (ay - pose.y) * wx) / across
            share = ((ax - pose.x) * dy - (ay - pose.y) * dx) / across
            if along >= 0 and 0 <= share <= 1:
                hits.append(along)
    return min(hits) if min(hits) <= 10.0 else math.inf


# No pose from which a ray meets the very end of a wall, where rounding decides.
@examples(200)
@given(
    x=st.integers(0, 2000).map(lambda n: n / 100 + 0.00317),
    y=st.integers(0, 1000).map(lambda n: n / 100 + 0.00271),
    yaw=st.integers(-400, 400).map(lambda n: n / 100 + 0.00113),
)
def test_rays_end_at_the_nearest_wall(x, y, yaw):
    pose = Pose(x, y, yaw)
    ranges = Scanner(World.model_validate(SMALL_WORLD)).ranges(pose)

    assert pytest.approx([first_hit(pose, ray) for ray in range(RAYS)]) == ranges
