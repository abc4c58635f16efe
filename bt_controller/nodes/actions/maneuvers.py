"""Nav2's behaviors: short motions, and waiting.

Lengths and speeds are in the world's unit of length; times are simulated seconds.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar, Final

from bt_controller.core.action_node import ACTION_INPUTS, ActionNode
from bt_controller.core.ports import BOOL, FINITE, input_port
from bt_controller.nodes import Family
from hmrsim.interfaces import nav2_msgs
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import Point

if TYPE_CHECKING:
    from bt_controller.core.ports import Port

_MANEUVER_INPUTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        **ACTION_INPUTS,
        "time_allowance": input_port(FINITE, "Time limit in seconds; 0 for none", default=10.0),
        "disable_collision_checks": input_port(BOOL, "Sent with the goal", default=False),
        "is_recovery": input_port(BOOL, "Ignored: recoveries are not counted", default=True),
    }
)


class Spin(ActionNode):
    """Turns in place."""

    ACTION = "spin"
    INPUTS: ClassVar = {**_MANEUVER_INPUTS, "spin_dist": input_port(FINITE, "Angle in radians", default=1.57)}

    def goal(self) -> nav2_msgs.Spin.Goal:
        """Return the goal of the input ports."""
        return nav2_msgs.Spin.Goal(
            target_yaw=self.read("spin_dist"),
            time_allowance=Duration.from_seconds(self.read("time_allowance")),
            disable_collision_checks=self.read("disable_collision_checks"),
        )


class Wait(ActionNode):
    """Stands still for the absolute value of the duration, as in Nav2."""

    ACTION = "wait"
    INPUTS: ClassVar = {**ACTION_INPUTS, "wait_duration": input_port(FINITE, "Duration in seconds", default=1.0)}

    def goal(self) -> nav2_msgs.Wait.Goal:
        """Return the goal of the input ports."""
        return nav2_msgs.Wait.Goal(time=Duration.from_seconds(abs(self.read("wait_duration"))))


class BackUp(ActionNode):
    """Drives straight back."""

    ACTION = "back_up"
    INPUTS: ClassVar = {
        **_MANEUVER_INPUTS,
        "backup_dist": input_port(FINITE, "Distance", default=0.15),
        "backup_speed": input_port(FINITE, "Speed", default=0.025),
    }

    def goal(self) -> nav2_msgs.BackUp.Goal:
        """Return the goal of the input ports."""
        return nav2_msgs.BackUp.Goal(
            target=Point(x=self.read("backup_dist")),
            speed=self.read("backup_speed"),
            time_allowance=Duration.from_seconds(self.read("time_allowance")),
            disable_collision_checks=self.read("disable_collision_checks"),
        )


class DriveOnHeading(ActionNode):
    """Drives straight ahead."""

    ACTION = "drive_on_heading"
    INPUTS: ClassVar = {
        **_MANEUVER_INPUTS,
        "dist_to_travel": input_port(FINITE, "Distance", default=0.15),
        "speed": input_port(FINITE, "Speed", default=0.025),
    }

    def goal(self) -> nav2_msgs.DriveOnHeading.Goal:
        """Return the goal of the input ports."""
        return nav2_msgs.DriveOnHeading.Goal(
            target=Point(x=self.read("dist_to_travel")),
            speed=self.read("speed"),
            time_allowance=Duration.from_seconds(self.read("time_allowance")),
            disable_collision_checks=self.read("disable_collision_checks"),
        )


FAMILY = Family.of("maneuvers", BackUp, DriveOnHeading, Spin, Wait)
