"""Goals and results in a few words."""

from __future__ import annotations

import pytest

from hmrsim.cli.goal_summary import summary
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import DockRobot, FollowWaypoints, NavigateToPose, Wait


def pose(x, y):
    """Return a pose at a point."""
    return PoseStamped(pose=Pose(position=Point(x=x, y=y)))


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        (NavigateToPose.Goal(pose=pose(512.0, 215.5)), "(512, 215.5)"),
        (NavigateToPose.Goal(), "(0, 0)"),
        (DockRobot.Goal(dock_id="charger_4"), "charger_4"),
        (Pickup.Goal(target_name="medicine"), "medicine"),
        (Wait.Goal(time=Duration(sec=2, nanosec=500_000_000)), "2.5 s"),
        (FollowWaypoints.Goal(poses=[pose(float(i), 0.0) for i in range(5)]), "(0, 0), (1, 0), (2, 0), and 2 more"),
        (Pickup.Goal.model_validate_json(Pickup.Goal(target_name="linen").model_dump_json()), "linen"),
    ],
)
def test_summary(goal, words):
    """A goal is told by what was asked for, not by its defaults."""
    assert words == summary(goal)
