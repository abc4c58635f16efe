"""Nodes for MoveIt's actions, with MoveIt's error codes, where 1 is success."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from bt_controller.core.action_node import ACTION_INPUTS, ActionNode
from bt_controller.core.ports import POSE, STRING, input_port
from bt_controller.nodes import Family
from hmrsim.interfaces import moveit_msgs
from hmrsim.interfaces.message import unbuilt
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes, PlaceLocation


class _MoveItNode(ActionNode):
    """An action whose result has a nested error code message."""

    PLAIN = True
    UNANSWERED = MoveItErrorCodes.FAILURE

    def code_of(self, result: Any) -> tuple[int, str]:
        """Return the code and the message of a result; it is not read if the goal has succeeded."""
        return (MoveItErrorCodes.SUCCESS, "") if result is None else (result.error_code.val, result.error_code.message)


class Pickup(_MoveItNode):
    """Picks an item up."""

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


FAMILY = Family.of("manipulation", Pickup, Place)
