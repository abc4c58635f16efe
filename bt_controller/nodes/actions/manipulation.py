"""Actions with items and docks: MoveIt's, whose error code for success is 1, and Nav2's docking."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from bt_controller.behaviours.robot_actions import missing_dock
from bt_controller.core.action_node import ACTION_INPUTS, ACTION_OUTPUTS, ActionNode
from bt_controller.core.node import PortError
from bt_controller.core.ports import BOOL, FINITE, INT, POSE, STRING, input_port, output_port
from bt_controller.nodes import Family
from hmrsim.interfaces import moveit_msgs
from hmrsim.interfaces.message import unbuilt
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes, PlaceLocation


class _MoveItNode(ActionNode):
    """An action whose result has a nested error code message."""

    PLAIN = True
    UNANSWERED = MoveItErrorCodes.FAILURE

    def code_of(self, result: Any) -> tuple[int, str]:
        """Return the code and the message of a result; success for a succeeded goal, whose result is not read."""
        return (MoveItErrorCodes.SUCCESS, "") if result is None else (result.error_code.val, result.error_code.message)


class Pickup(_MoveItNode):
    """Picks up the item ``target_name``."""

    ACTION = "pickup"
    INPUTS: ClassVar = {**ACTION_INPUTS, "target_name": input_port(STRING, "The item")}

    def goal(self) -> Mapping[str, Any]:
        """Return the goal of the input ports."""
        return unbuilt(moveit_msgs.Pickup.Goal, target_name=self.read("target_name"))


class Place(_MoveItNode):
    """Places a held item at the robot's pose, or at a pose within its reach."""

    ACTION = "place"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "attached_object_name": input_port(STRING, "The item; by default the one that the robot holds", default=""),
        "place_pose": input_port(POSE, "Pose of the item; by default the robot's pose", required=False),
    }

    def goal(self) -> Mapping[str, Any]:
        """Return the goal of the input ports."""
        pose = self.read("place_pose")
        return unbuilt(
            moveit_msgs.Place.Goal,
            attached_object_name=self.read("attached_object_name"),
            place_locations=[] if pose is None else [unbuilt(PlaceLocation, place_pose=pose)],
        )


_SUCCESS = output_port(BOOL, "Whether the action succeeded")


class _DockNode(ActionNode):
    """An action whose result says whether it succeeded."""

    def clear_result(self) -> None:
        """Write that the action did not succeed."""
        self.write("success", value=False)


class DockRobot(_DockNode):
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
        """Look up the action, and the dock if the tree's file names it.

        Raises:
            NotServed: There is no such robot, or it has no such action.
            PortError: A port's value in the file is invalid, or there is no such dock.
            SimulatorNotFound: No simulator answers.
        """
        super().setup(**kwargs)
        dock = self.entry("dock_id")
        if isinstance(dock, str) and dock and (why := missing_dock(dock, kwargs.get("places"))):
            raise PortError(f"{self.located}: port 'dock_id': {why}")


class UndockRobot(_DockNode):
    """Leaves the dock for its staging pose."""

    ACTION = "undock_robot"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "dock_type": input_port(STRING, "The type of the dock", default=""),
        "max_undocking_time": input_port(FINITE, "Time limit in seconds", default=30.0),
    }
    OUTPUTS: ClassVar = {**ACTION_OUTPUTS, "success": _SUCCESS}


FAMILY = Family.of_module(__name__)
