"""Messages without the parts that say nothing."""

from __future__ import annotations

import pytest

from hmrsim.cli.plain import plain
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes, Pickup
from hmrsim.interfaces.nav2_msgs import NavigateToPose, Wait
from hmrsim.interfaces.std_msgs import Header


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        (Pickup.Result(error_code=MoveItErrorCodes(val=1)), {"error_code": {"val": 1}, "planning_time": 0.0}),
        (Wait.Result(), {"total_elapsed_time": {"sec": 0, "nanosec": 0}, "error_code": 0}),
        (NavigateToPose.Result(error_code=208, error_msg="no way"), {"error_code": 208, "error_msg": "no way"}),
    ],
)
def test_empty_parts_are_left_out(message, shown):
    """Numbers and the error's code stay."""
    assert shown == plain(message)


def test_a_robot_at_the_origin_has_a_position():
    """Zero is a place; the orientation that everybody has by default says nothing."""
    stamped = PoseStamped(header=Header(frame_id="map"))

    assert {"position": {"x": 0.0, "y": 0.0, "z": 0.0}} == plain(stamped)["pose"]


def test_whole_numbers_are_exact():
    """They have no noise."""
    assert {"sec": 1_234_567_891, "nanosec": 0} == plain(Duration(sec=1_234_567_891))
