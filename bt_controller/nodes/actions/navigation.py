"""Nav2's navigation actions: to a pose, and through poses."""

from __future__ import annotations

from typing import ClassVar

from bt_controller.core.action_node import ACTION_INPUTS, ActionNode
from bt_controller.core.ports import POSE, POSES, STRING, input_port
from bt_controller.nodes import Family
from hmrsim.interfaces.nav2_msgs import NavigateThroughPoses as ThroughPoses
from hmrsim.interfaces.nav2_msgs import NavigateToPose as ToPose
from hmrsim.interfaces.nav_msgs import Goals

_TREE = input_port(STRING, "Sent with the goal and ignored: simulated robots have no trees", default="")


class NavigateToPose(ActionNode):
    """Drives to ``goal``."""

    ACTION = "navigate_to_pose"
    INPUTS: ClassVar = {**ACTION_INPUTS, "goal": input_port(POSE, "Destination"), "behavior_tree": _TREE}

    def goal(self) -> ToPose.Goal:
        """Return the goal of the input ports."""
        return ToPose.Goal(pose=self.read("goal"), behavior_tree=self.read("behavior_tree"))


class NavigateThroughPoses(ActionNode):
    """Drives through ``goals`` to the last of them."""

    ACTION = "navigate_through_poses"
    INPUTS: ClassVar = {**ACTION_INPUTS, "goals": input_port(POSES, "Destinations in order"), "behavior_tree": _TREE}

    def goal(self) -> ThroughPoses.Goal:
        """Return the goal of the input ports."""
        return ThroughPoses.Goal(poses=Goals(goals=self.read("goals")), behavior_tree=self.read("behavior_tree"))


FAMILY = Family.of("navigation", NavigateThroughPoses, NavigateToPose)
