"""Nav2's actions that plan and follow paths."""

from __future__ import annotations

from typing import Any, ClassVar

from bt_controller.core.action_node import ACTION_INPUTS, ACTION_OUTPUTS, ActionNode
from bt_controller.core.ports import (
    BOOL,
    CONTROLLER,
    DOUBLE,
    FINITE,
    INT,
    PATH,
    PLANNER,
    POSE,
    POSES,
    SMOOTHER,
    STRING,
    TRACKING,
    input_port,
    output_port,
)
from bt_controller.nodes import Family
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.nav2_msgs import ComputePathThroughPoses as ComputeThrough
from hmrsim.interfaces.nav2_msgs import ComputePathToPose as Compute
from hmrsim.interfaces.nav2_msgs import FollowPath as Follow
from hmrsim.interfaces.nav2_msgs import SmoothPath as Smooth
from hmrsim.interfaces.nav2_msgs import TrackingFeedback
from hmrsim.interfaces.nav_msgs import Goals, Path

_PLANNER_ID = input_port(PLANNER, "The planner: GridBased, or empty", default="")


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
        "planner_id": _PLANNER_ID,
        "viapoints": input_port(POSES, "Ignored: the path follows the lanes", required=False),
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


class ComputePathThroughPoses(ActionNode):
    """Plans a path through ``goals``, from the robot's pose or from ``start``, and writes it to ``path``.

    If there is no path to one of them, and upon a halt, it writes a path without poses.
    """

    ACTION = "compute_path_through_poses"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "goals": input_port(POSES, "Destinations in order"),
        "start": input_port(POSE, "Start; by default the robot's pose", required=False),
        "planner_id": _PLANNER_ID,
    }
    OUTPUTS: ClassVar = {
        **ACTION_OUTPUTS,
        "path": output_port(PATH, "The path"),
        "last_reached_index": output_port(INT, "-1: a path leads to all goals, or there is none"),
    }

    def goal(self) -> ComputeThrough.Goal:
        """Return the goal of the input ports."""
        start = self.read("start")
        return ComputeThrough.Goal(
            goals=Goals(goals=self.read("goals")),
            start=start or PoseStamped(),
            use_start=start is not None,
            planner_id=self.read("planner_id"),
        )

    def write_result(self, result: Any) -> None:
        """Write the path."""
        self.write("path", result.path)
        self.write("last_reached_index", result.last_reached_index)

    def clear_result(self) -> None:
        """Write a path without poses."""
        self.write("path", Path())
        self.write("last_reached_index", ComputeThrough.Result.ALL_GOALS)


class SmoothPath(ActionNode):
    """Smooths a path: poses that repeat a place are removed, and each pose but the last one faces the next."""

    ACTION = "smooth_path"
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "unsmoothed_path": input_port(PATH, "The path"),
        "max_smoothing_duration": input_port(FINITE, "Sent with the goal; smoothing takes no time", default=3.0),
        "check_for_collisions": input_port(BOOL, "Whether to fail if something is in the way", default=False),
        "smoother_id": input_port(SMOOTHER, "The smoother: simple_smoother, route_smoother or empty", default=""),
    }
    OUTPUTS: ClassVar = {
        **ACTION_OUTPUTS,
        "smoothed_path": output_port(PATH, "The smoothed path"),
        "smoothing_duration": output_port(DOUBLE, "Duration in seconds"),
        "was_completed": output_port(BOOL, "Whether the path is as smooth as it can be"),
    }

    def goal(self) -> Smooth.Goal:
        """Return the goal of the input ports."""
        return Smooth.Goal(
            path=self.read("unsmoothed_path"),
            smoother_id=self.read("smoother_id"),
            max_smoothing_duration=Duration.from_seconds(self.read("max_smoothing_duration")),
            check_for_collisions=self.read("check_for_collisions"),
        )

    def write_result(self, result: Any) -> None:
        """Write the path."""
        self.write("smoothed_path", result.path)
        self.write("smoothing_duration", result.smoothing_duration.to_seconds())
        self.write("was_completed", result.was_completed)


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
        "tracking_feedback": output_port(TRACKING, "How the robot keeps to its path; written if a node reads it"),
    }
    FEEDBACK_OUTPUTS = ("tracking_feedback",)

    def goal(self) -> Follow.Goal:
        """Return the goal of the input ports."""
        return Follow.Goal(
            path=self.read("path"),
            controller_id=self.read("controller_id"),
            goal_checker_id=self.read("goal_checker_id"),
            progress_checker_id=self.read("progress_checker_id"),
        )

    def write_feedback(self, feedback: Any) -> None:
        """Write how the robot keeps to its path; each write lets the tree be ticked again."""
        if self.wants_feedback:
            self.write("tracking_feedback", feedback.tracking_feedback)

    def write_result(self, _result: Any) -> None:
        """Write that the robot follows no path any more."""
        self.clear_result()

    def clear_result(self) -> None:
        """Write that the robot follows no path."""
        if self.wants_feedback:
            self.write("tracking_feedback", TrackingFeedback())

    def should_replace_goal(self) -> bool:
        """Return whether the goal of the input ports differs from the active one."""
        goal = self.goal()
        return bool(goal.path.poses) and goal != self._sent


FAMILY = Family.of("paths", ComputePathThroughPoses, ComputePathToPose, FollowPath, SmoothPath)
