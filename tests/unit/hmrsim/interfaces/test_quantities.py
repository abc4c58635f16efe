"""What values each quantity takes, and what is said of others."""

from __future__ import annotations

import pytest

from hmrsim.interfaces.geometry_msgs import PoseStamped, Quaternion
from hmrsim.interfaces.nav2_msgs import DriveOnHeading, FollowPath, NavigateToPose, Spin
from hmrsim.interfaces.nav_msgs import Path
from hmrsim.interfaces.quantities import ANGLE, REAL_TIME_FACTOR, SECONDS, SIGNED_SPEED, flaw


@pytest.mark.parametrize(
    ("quantity", "value", "wrong"),
    [
        (SECONDS, 0.0, ""),
        (SECONDS, -0.5, "-0.5 s is not from 0 to 1e+09 s"),
        (ANGLE, -6.28, ""),
        (ANGLE, 1.7e308, "1.7e+308 rad is not from -10000 to 10000 rad"),
        (SIGNED_SPEED, 0.0, ""),
        (SIGNED_SPEED, -2.0, ""),
        (SIGNED_SPEED, 5e-324, "4.94066e-324 units/s is not 0, or from 1e-09 to 1e+09 units/s, or its negative"),
        (REAL_TIME_FACTOR, 5e-324, "4.94066e-324 is not 0, or from 1e-06 to 1e+06"),
    ],
)
def test_a_value_out_of_range_is_reported_with_the_range(quantity, value, wrong):
    """The error has the range with its unit, if it has one."""
    assert wrong == quantity.flaw(value)


@pytest.mark.parametrize(
    ("message", "wrong"),
    [
        (NavigateToPose.Goal(), ""),
        (Spin.Goal(target_yaw=1e5), "target_yaw: 100000 rad is not from -10000 to 10000 rad"),
        (
            DriveOnHeading.Goal(speed=1e-10),
            "speed: 1e-10 units/s is not 0, or from 1e-09 to 1e+09 units/s, or its negative",
        ),
        (
            FollowPath.Goal(
                path=Path(poses=[PoseStamped(), PoseStamped.model_validate({"pose": {"orientation": {"z": 1e7}}})])
            ),
            "path.poses.1.pose.orientation.z: 1e+07 is not from -1e+06 to 1e+06",
        ),
        (Quaternion(w=-1e300), "w: -1e+300 is not from -1e+06 to 1e+06"),
    ],
)
def test_a_message_is_reported_with_the_path_to_its_value(message, wrong):
    """The error has the path of the first invalid value."""
    assert wrong == flaw(message)
