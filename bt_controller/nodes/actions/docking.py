"""Nav2's actions at docks."""

from __future__ import annotations

from typing import Any, ClassVar

from bt_controller.core.action_node import ACTION_INPUTS, ACTION_OUTPUTS, ActionNode
from bt_controller.core.ports import BOOL, FINITE, INT, POSE, STRING, input_port, output_port
from bt_controller.nodes import Family
from hmrsim.interfaces import nav2_msgs
from hmrsim.interfaces.geometry_msgs import PoseStamped

_SUCCESS = output_port(BOOL, "Whether it has been done")


class DockRobot(ActionNode):
    """Drives to a dock and stays there: the dock of a name, or with ``use_dock_id="false"`` the one at a pose."""

    ACTION = "dock_robot"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "use_dock_id": input_port(BOOL, "Whether the name counts, or else the pose", default=True),
        "dock_id": input_port(STRING, "The dock's name", default=""),
        "dock_pose": input_port(POSE, "Where the dock is", required=False),
        "dock_type": input_port(STRING, "What kind of dock is at that pose", default=""),
        "max_staging_time": input_port(FINITE, "How long the way there may take, in seconds", default=1000.0),
        "navigate_to_staging_pose": input_port(BOOL, "Whether to drive there first", default=True),
    }
    OUTPUTS: ClassVar = {
        **ACTION_OUTPUTS,
        "success": _SUCCESS,
        "num_retries": output_port(INT, "How often it was retried"),
    }

    def goal(self) -> nav2_msgs.DockRobot.Goal:
        """Return the goal of the input ports."""
        return nav2_msgs.DockRobot.Goal(
            use_dock_id=self.read("use_dock_id"),
            dock_id=self.read("dock_id"),
            dock_pose=self.read("dock_pose") or PoseStamped(),
            dock_type=self.read("dock_type"),
            max_staging_time=self.read("max_staging_time"),
            navigate_to_staging_pose=self.read("navigate_to_staging_pose"),
        )

    def take(self, result: Any) -> None:
        """Tell that it has been done."""
        self.write("success", result.success)
        self.write("num_retries", result.num_retries)

    def take_nothing(self) -> None:
        """Tell that it has not been done."""
        self.write("success", value=False)


class UndockRobot(ActionNode):
    """Leaves the dock."""

    ACTION = "undock_robot"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "dock_type": input_port(STRING, "What kind of dock it is", default=""),
        "max_undocking_time": input_port(FINITE, "How long it may take, in seconds", default=30.0),
    }
    OUTPUTS: ClassVar = {**ACTION_OUTPUTS, "success": _SUCCESS}

    def goal(self) -> nav2_msgs.UndockRobot.Goal:
        """Return the goal of the input ports."""
        return nav2_msgs.UndockRobot.Goal(
            dock_type=self.read("dock_type"), max_undocking_time=self.read("max_undocking_time")
        )

    def take(self, result: Any) -> None:
        """Tell that it has been done."""
        self.write("success", result.success)

    def take_nothing(self) -> None:
        """Tell that it has not been done."""
        self.write("success", value=False)


FAMILY = Family("docking", {"DockRobot": DockRobot, "UndockRobot": UndockRobot})
