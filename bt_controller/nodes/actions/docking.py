"""Nav2's actions at docks."""

from __future__ import annotations

from typing import Any, ClassVar

from bt_controller.behaviours.docks import missing_dock
from bt_controller.core.action_node import ACTION_INPUTS, ACTION_OUTPUTS, ActionNode
from bt_controller.core.node import PortError
from bt_controller.core.ports import BOOL, FINITE, INT, POSE, STRING, input_port, output_port
from bt_controller.nodes import Family
from hmrsim.interfaces import nav2_msgs
from hmrsim.interfaces.geometry_msgs import PoseStamped

_SUCCESS = output_port(BOOL, "Whether the action succeeded")


class DockRobot(ActionNode):
    """Drives to a dock and stays there: the dock ``dock_id``, or with ``use_dock_id="false"`` the one at a pose."""

    ACTION = "dock_robot"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "use_dock_id": input_port(BOOL, "Whether to use dock_id, or else dock_pose", default=True),
        "dock_id": input_port(STRING, "The dock's name", default=""),
        "dock_pose": input_port(POSE, "The dock's pose", required=False),
        "dock_type": input_port(STRING, "The type of the dock at that pose", default=""),
        "max_staging_time": input_port(FINITE, "Time limit of the drive to the dock, in seconds", default=1000.0),
        "navigate_to_staging_pose": input_port(BOOL, "Whether to drive to the dock first", default=True),
    }
    OUTPUTS: ClassVar = {
        **ACTION_OUTPUTS,
        "success": _SUCCESS,
        "num_retries": output_port(INT, "Number of retries"),
    }

    def setup(self, **kwargs: Any) -> None:
        """Look up the action, and the dock if the file names it.

        Raises:
            NotServed: There is no such robot, or it has no such action.
            PortError: A port's value in the file is invalid, or there is no such dock.
            SimulatorNotFound: No simulator answers.
        """
        super().setup(**kwargs)
        dock = self.entry("dock_id")
        if isinstance(dock, str) and dock and (why := missing_dock(dock, kwargs.get("places"))):
            raise PortError(f"{self.located}: port 'dock_id': {why}")

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

    def write_result(self, result: Any) -> None:
        """Write that the action succeeded."""
        self.write("success", result.success)
        self.write("num_retries", result.num_retries)

    def clear_result(self) -> None:
        """Write that the action did not succeed."""
        self.write("success", value=False)


class UndockRobot(ActionNode):
    """Leaves the dock."""

    ACTION = "undock_robot"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "dock_type": input_port(STRING, "The type of the dock", default=""),
        "max_undocking_time": input_port(FINITE, "Time limit in seconds", default=30.0),
    }
    OUTPUTS: ClassVar = {**ACTION_OUTPUTS, "success": _SUCCESS}

    def goal(self) -> nav2_msgs.UndockRobot.Goal:
        """Return the goal of the input ports."""
        return nav2_msgs.UndockRobot.Goal(
            dock_type=self.read("dock_type"), max_undocking_time=self.read("max_undocking_time")
        )

    def write_result(self, result: Any) -> None:
        """Write that the action succeeded."""
        self.write("success", result.success)

    def clear_result(self) -> None:
        """Write that the action did not succeed."""
        self.write("success", value=False)


FAMILY = Family.of("docking", DockRobot, UndockRobot)
