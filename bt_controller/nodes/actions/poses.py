"""Nav2's nodes that read the robot's pose or edit lists of goals."""

from __future__ import annotations

from typing import ClassVar

from py_trees.common import Status

from bt_controller.core.node import Leaf
from bt_controller.core.ports import FINITE, INT, POSE, POSES, Kind, input_port, output_port
from bt_controller.nodes import Family
from bt_controller.nodes.located import BASE_FRAME, GLOBAL_FRAME, Located
from bt_controller.nodes.paths import apart
from hmrsim.interfaces.nav2_msgs import WaypointStatus

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


FAMILY = Family.of("poses", AppendGoalPoseToGoals, GetCurrentPose, GetNextFewGoals, RemovePassedGoals)
