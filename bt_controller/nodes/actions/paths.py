"""Nav2's actions on paths and poses: planning, following, cutting and joining paths, and editing lists of goals."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from py_trees.common import Status

from bt_controller.core.action_node import ACTION_INPUTS, ACTION_OUTPUTS, ActionNode
from bt_controller.core.node import Leaf
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
    Kind,
    input_port,
    output_port,
)
from bt_controller.nodes import Family
from bt_controller.nodes.poses import BASE_FRAME, GLOBAL_FRAME, Located, Trail, apart, length_of, part_of, point_of
from hmrsim.geometry import SAME_PLACE, heading
from hmrsim.interfaces.nav2_msgs import TrackingFeedback, WaypointStatus
from hmrsim.interfaces.nav_msgs import Path
from hmrsim_zenoh.client.places import pose_at

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message


_PLANNER_ID = input_port(PLANNER, "The planner: GridBased, or empty", default="")


class ComputePathToPose(ActionNode):
    """Plans a path to ``goal``, from the robot's pose or from ``start``, and writes it to ``path``.

    If there is no path, and upon a halt, it writes a path without poses.
    """

    ACTION = "compute_path_to_pose"
    CLEARED = ("path",)
    INPUTS: ClassVar = {
        **ACTION_INPUTS,
        "goal": input_port(POSE, "Destination"),
        "start": input_port(POSE, "Start; by default the robot's pose", required=False),
        "use_start": input_port(BOOL, "Whether to use start", default=True),
        "planner_id": _PLANNER_ID,
        "viapoints": input_port(POSES, "Ignored: the path follows the lanes", required=False),
    }
    OUTPUTS: ClassVar = {**ACTION_OUTPUTS, "path": output_port(PATH, "The path")}

    def goal(self) -> Message:
        """Return the goal of the input ports."""
        return self.goal_with(use_start=self.read("start") is not None and self.read("use_start"))


class ComputePathThroughPoses(ActionNode):
    """Plans a path through ``goals``, from the robot's pose or from ``start``, and writes it to ``path``.

    If there is no path to one of them, and upon a halt, it writes a path without poses.
    """

    ACTION = "compute_path_through_poses"
    CLEARED = ("path", "last_reached_index")
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

    def goal(self) -> Message:
        """Return the goal of the input ports."""
        return self.goal_with(use_start=self.read("start") is not None)


class SmoothPath(ActionNode):
    """Smooths a path: poses that repeat a place are removed, and each pose but the last one faces the next."""

    ACTION = "smooth_path"
    FIELDS: ClassVar = {"unsmoothed_path": "path", "smoothed_path": "path"}
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

    def write_feedback(self, feedback: Any) -> None:
        """Write how the robot keeps to its path; each write lets the tree be ticked again."""
        if self.wants_feedback:
            self.write("tracking_feedback", feedback.tracking_feedback)

    def write_result(self, _result: Any) -> None:
        """Write that the robot follows no path."""
        self.clear_result()

    def clear_result(self) -> None:
        """Write that the robot follows no path."""
        if self.wants_feedback:
            self.write("tracking_feedback", TrackingFeedback())

    def should_replace_goal(self) -> bool:
        """Return whether the goal of the input ports differs from the active one."""
        goal: Any = self.goal()
        return bool(goal.path.poses) and goal != self._sent


_NONE = Path()


class TruncatePath(Leaf):
    """Writes a path without its last ``distance`` to ``output_path``; the new last pose faces the goal."""

    INPUTS: ClassVar = {
        "input_path": input_port(PATH, "The path", required=False),
        "distance": input_port(FINITE, "Length to remove, in the world's unit of length", default=1.0),
    }
    OUTPUTS: ClassVar = {"output_path": output_port(PATH, "The truncated path")}

    def update(self) -> Status:
        """Write the path without its end."""
        path = self.read("input_path") or _NONE
        if path.poses:
            end = path.poses[-1]
            path = part_of(path, 0.0, max(0.0, length_of(path) - self.read("distance")))
            x, y = point_of(path.poses[-1])
            if math.dist((x, y), point_of(end)) > SAME_PLACE:
                faced = pose_at(x, y, heading((x, y), point_of(end)))
                last = faced.model_copy(update={"header": end.header})
                path = Path(header=path.header, poses=[*path.poses[:-1], last])
        self.write("output_path", path)
        return Status.SUCCESS


class TruncatePathLocal(Located, Leaf):
    """Writes the part of a path around the robot to ``output_path``.

    It begins ``distance_backward`` before the path's point closest to the robot, or to ``pose``, and ends
    ``distance_forward`` after it, or with the path if that is negative. The search for the closest point covers the
    whole path, or ``max_robot_pose_search_dist`` after the previous one. Distances are along the path, in the world's
    unit of length.
    """

    INPUTS: ClassVar = {
        "input_path": input_port(PATH, "The path", required=False),
        "distance_forward": input_port(FINITE, "Length after the robot; negative for the whole rest", default=8.0),
        "distance_backward": input_port(FINITE, "Length before the robot", default=4.0),
        "robot_frame": BASE_FRAME,
        "robot_base_frame": BASE_FRAME,
        "transform_tolerance": input_port(DOUBLE, "Ignored", default=0.2),
        "pose": input_port(POSE, "Pose to use instead of the robot's", required=False),
        "angular_distance_weight": input_port(DOUBLE, "Weight of a radian relative to a unit of length", default=0.0),
        "max_robot_pose_search_dist": input_port(DOUBLE, "Search distance after the previous point", default=math.inf),
    }
    OUTPUTS: ClassVar = {"output_path": output_port(PATH, "The part of the path")}

    def __init__(self, name: str, behaviour_class_name: str | None = None) -> None:
        super().__init__(name, behaviour_class_name=behaviour_class_name)
        self._trail = Trail()

    def update(self) -> Status:
        """Write the part of the path around the robot."""
        path = self.read("input_path") or _NONE
        if path.poses:
            at = self._trail.reached(
                path,
                self.read("pose") or self.here,
                ahead=self.read("max_robot_pose_search_dist"),
                weight=self.read("angular_distance_weight"),
            )
            forward = self.read("distance_forward")
            end = math.inf if forward < 0.0 else at + forward
            path = part_of(path, at - self.read("distance_backward"), end)
        self.write("output_path", path)
        return Status.SUCCESS


class ConcatenatePaths(Leaf):
    """Writes the concatenation of two paths to ``output_path``; fails if it has no poses."""

    INPUTS: ClassVar = {
        "input_path1": input_port(PATH, "The first path", required=False),
        "input_path2": input_port(PATH, "The second path", required=False),
    }
    OUTPUTS: ClassVar = {"output_path": output_port(PATH, "The concatenation")}

    def update(self) -> Status:
        """Write the second path after the first one."""
        first, second = (self.read(port) or _NONE for port in self.INPUTS)
        if not first.poses and not second.poses:
            self.feedback_message = "there are no poses"
            return Status.FAILURE
        header = first.header if first.header != _NONE.header else second.header
        self.write("output_path", Path(header=header, poses=[*first.poses, *second.poses]))
        return Status.SUCCESS


class GetPoseFromPath(Leaf):
    """Writes one pose of a path to ``pose``; fails if there is no such pose."""

    INPUTS: ClassVar = {
        "path": input_port(PATH, "The path", required=False),
        "index": input_port(INT, "Index of the pose, from 0; negative from the end", default=0),
    }
    OUTPUTS: ClassVar = {"pose": output_port(POSE, "The pose")}

    def update(self) -> Status:
        """Write the pose."""
        path, index = self.read("path") or _NONE, self.read("index")
        if not -len(path.poses) <= index < len(path.poses):
            self.feedback_message = f"no pose {index} in a path of {len(path.poses)}"
            return Status.FAILURE
        pose = path.poses[index]
        self.write("pose", pose if pose.header.frame_id else pose.model_copy(update={"header": path.header}))
        return Status.SUCCESS


_INPUT_GOALS = input_port(POSES, "The goals")
_OUTPUT_GOALS = output_port(POSES, "The goals")


def _no_text(text: str, _places: object) -> list[WaypointStatus]:
    raise ValueError(f"{text!r} is not a list of statuses; expected a key of the blackboard")


_STATUSES = Kind("nav2_msgs/WaypointStatus[]", list, _no_text)


class GetCurrentPose(Located, Leaf):
    """Writes the robot's pose to ``current_pose``."""

    INPUTS: ClassVar = {"global_frame": GLOBAL_FRAME, "robot_base_frame": BASE_FRAME}
    OUTPUTS: ClassVar = {"current_pose": output_port(POSE, "The robot's pose")}

    def update(self) -> Status:
        """Write the pose."""
        self.write("current_pose", self.here)
        return Status.SUCCESS


class RemovePassedGoals(Located, Leaf):
    """Writes the goals to ``output_goals``, without leading ones near the robot; the last one always remains.

    In ``input_waypoint_statuses``, if given, the removed goals become COMPLETED.
    """

    INPUTS: ClassVar = {
        "input_goals": _INPUT_GOALS,
        "radius": input_port(FINITE, "Largest distance of a passed goal, in the world's unit of length", default=0.5),
        "global_frame": GLOBAL_FRAME,
        "robot_base_frame": BASE_FRAME,
        "input_waypoint_statuses": input_port(_STATUSES, "The waypoint statuses", required=False),
    }
    OUTPUTS: ClassVar = {
        "output_goals": _OUTPUT_GOALS,
        "output_waypoint_statuses": output_port(_STATUSES, "The updated waypoint statuses"),
    }

    def update(self) -> Status:
        """Remove the passed goals."""
        goals, statuses = list(self.read("input_goals")), list(self.read("input_waypoint_statuses") or ())
        while len(goals) > 1 and apart(goals[0], self.here) <= self.read("radius"):
            passed = goals.pop(0)
            for index, status in enumerate(statuses):
                if status.waypoint_status == WaypointStatus.PENDING and status.waypoint_pose == passed:
                    statuses[index] = status.model_copy(update={"waypoint_status": WaypointStatus.COMPLETED})
                    break
        self.write("output_goals", goals)
        if statuses:
            self.write("output_waypoint_statuses", statuses)
        return Status.SUCCESS


class AppendGoalPoseToGoals(Leaf):
    """Writes the goals with one more at the end to ``output_goals``."""

    INPUTS: ClassVar = {"input_goals": _INPUT_GOALS, "goal_pose": input_port(POSE, "The goal to append")}
    OUTPUTS: ClassVar = {"output_goals": _OUTPUT_GOALS}

    def update(self) -> Status:
        """Append the goal to the list."""
        self.write("output_goals", [*self.read("input_goals"), self.read("goal_pose")])
        return Status.SUCCESS


class GetNextFewGoals(Leaf):
    """Writes the first ``num_goals`` goals to ``output_goals``; fails if there are no goals."""

    INPUTS: ClassVar = {"input_goals": _INPUT_GOALS, "num_goals": input_port(INT, "Number of goals")}
    OUTPUTS: ClassVar = {"output_goals": _OUTPUT_GOALS}

    def update(self) -> Status:
        """Write the first goals."""
        goals = self.read("input_goals")
        if not goals:
            self.feedback_message = "there are no goals"
            return Status.FAILURE
        self.write("output_goals", goals[: max(0, self.read("num_goals"))])
        return Status.SUCCESS


FAMILY = Family.of_module(__name__)
