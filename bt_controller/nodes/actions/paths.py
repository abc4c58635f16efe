"""Nav2's actions that plan and follow paths."""

from __future__ import annotations

from typing import Any, ClassVar

from bt_controller.core.action_node import ACTION_INPUTS, ACTION_OUTPUTS, ActionNode
from bt_controller.core.ports import ANY, BOOL, CONTROLLER, PATH, PLANNER, POSE, STRING, input_port, output_port
from bt_controller.nodes import Family
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.nav2_msgs import ComputePathToPose as Compute
from hmrsim.interfaces.nav2_msgs import FollowPath as Follow
from hmrsim.interfaces.nav_msgs import Path


class ComputePathToPose(ActionNode):
    """Plans a path to ``goal``, from the robot's pose or from ``start``, and writes it to ``path``.

    If there is no path, and upon a halt, it writes a path without poses.
    """

    ACTION = "compute_path_to_pose"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "goal": input_port(POSE, "Destination"),
        "start": input_port(POSE, "Start; by default the robot's pose", required=False),
        "use_start": input_port(BOOL, "Whether to use start", default=True),
        "planner_id": input_port(PLANNER, "The planner: GridBased, or empty", default=""),
    }
    OUTPUTS: ClassVar = {**ACTION_OUTPUTS, "path": output_port(PATH, "The path")}

    def goal(self) -> Compute.Goal:
        """Return the goal of the input ports."""
        start = self.read("start")
        return Compute.Goal(
            goal=self.read("goal"),
            start=start or PoseStamped(),
            use_start=start is not None and self.read("use_start"),
            planner_id=self.read("planner_id"),
        )

    def write_result(self, result: Any) -> None:
        """Write the path."""
        self.write("path", result.path)

    def clear_result(self) -> None:
        """Write a path without poses."""
        self.write("path", Path())


class FollowPath(ActionNode):
    """Follows ``path``; when the path or an id changes, the new goal preempts the old one.

    A path without poses, which a planner writes while it has none, does not replace the current one.
    """

    ACTION = "follow_path"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "path": input_port(PATH, "The path"),
        "controller_id": input_port(CONTROLLER, "The controller: FollowPath, or empty", default=""),
        "goal_checker_id": input_port(STRING, "Any: simulated robots arrive exactly", default=""),
        "progress_checker_id": input_port(STRING, "Any: the world's traffic rules apply", default=""),
        "path_handler_id": input_port(STRING, "Any: there is one path handler", default=""),
    }
    OUTPUTS: ClassVar = {
        **ACTION_OUTPUTS,
        "tracking_feedback": output_port(ANY, "Never written: simulated robots are never off their path"),
    }

    def goal(self) -> Follow.Goal:
        """Return the goal of the input ports."""
        return Follow.Goal(
            path=self.read("path"),
            controller_id=self.read("controller_id"),
            goal_checker_id=self.read("goal_checker_id"),
            progress_checker_id=self.read("progress_checker_id"),
        )

    def should_replace_goal(self) -> bool:
        """Return whether the goal of the input ports differs from the active one."""
        goal = self.goal()
        return bool(goal.path.poses) and goal != self._sent


FAMILY = Family.of("paths", ComputePathToPose, FollowPath)
