"""Nav2's actions that plan a path, and drive along one."""

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
    """Plans a path to ``goal``, from where the robot is or from ``start``, and puts it on ``path``.

    Without one, and when it is halted, it puts a path without poses there.
    """

    ACTION = "compute_path_to_pose"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "goal": input_port(POSE, "Where to"),
        "start": input_port(POSE, "Where from; from where the robot is if left out", required=False),
        "use_start": input_port(BOOL, "Whether start counts", default=True),
        "planner_id": input_port(PLANNER, "Which planner: GridBased, or none", default=""),
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

    def take(self, result: Any) -> None:
        """Give the path."""
        self.write("path", result.path)

    def take_nothing(self) -> None:
        """Give a path without poses."""
        self.write("path", Path())


class FollowPath(ActionNode):
    """Drives along ``path``; when another one comes, or another id, it goes on along that.

    A path without poses does not replace the current one: the planner has no path for the moment.
    """

    ACTION = "follow_path"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "path": input_port(PATH, "Where along"),
        "controller_id": input_port(CONTROLLER, "Which controller: FollowPath, or none", default=""),
        "goal_checker_id": input_port(STRING, "Any: robots here arrive exactly", default=""),
        "progress_checker_id": input_port(STRING, "Any: the world's rules of traffic count", default=""),
        "path_handler_id": input_port(STRING, "Any: robots here have one way to handle paths", default=""),
    }
    OUTPUTS: ClassVar = {
        **ACTION_OUTPUTS,
        "tracking_feedback": output_port(ANY, "Never written: robots here are never off their path"),
    }

    def goal(self) -> Follow.Goal:
        """Return the goal of the input ports."""
        return Follow.Goal(
            path=self.read("path"),
            controller_id=self.read("controller_id"),
            goal_checker_id=self.read("goal_checker_id"),
            progress_checker_id=self.read("progress_checker_id"),
        )

    def wants_other_goal(self) -> bool:
        """Return whether the ports make another goal than the one that was sent."""
        goal = self.goal()
        return bool(goal.path.poses) and goal != self._sent


FAMILY = Family("paths", {"ComputePathToPose": ComputePathToPose, "FollowPath": FollowPath})
