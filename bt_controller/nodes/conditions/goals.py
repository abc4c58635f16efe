"""Nav2's conditions on goals: whether the goal has changed, and whether the robot is near it.

Lengths are in the world's unit.
"""

from __future__ import annotations

import math
from typing import Any, ClassVar

from py_trees.common import Status

from bt_controller.core.node import Condition
from bt_controller.core.ports import DOUBLE, FINITE, PATH, POSE, input_port
from bt_controller.nodes import Family
from bt_controller.nodes.located import BASE_FRAME, GLOBAL_FRAME, GOAL_PORTS, Located, goals_of
from bt_controller.nodes.paths import Trail, apart, length_of


def _if(true: bool) -> Status:  # noqa: FBT001 - a conversion of a bool
    return Status.SUCCESS if true else Status.FAILURE


class GoalReached(Located, Condition):
    """Succeeds if the robot is within 0.25 of ``goal``, whatever its orientation."""

    INPUTS: ClassVar = {
        "goal": input_port(POSE, "Destination"),
        "global_frame": GLOBAL_FRAME,
        "robot_base_frame": BASE_FRAME,
    }
    TOLERANCE: ClassVar = 0.25

    def update(self) -> Status:
        """Compare the robot's pose with the goal."""
        return _if(apart(self.read("goal"), self.here) <= self.TOLERANCE)


class GoalUpdated(Condition):
    """Succeeds if ``goal`` or ``goals`` have changed since the last tick; fails at the first tick after being idle."""

    INPUTS: ClassVar = GOAL_PORTS

    _known: Any = None

    def update(self) -> Status:
        """Compare the goals with those of the last tick."""
        known, self._known = self._known, goals_of(self)
        return _if(self.status is not Status.INVALID and known != self._known)


class GlobalUpdatedGoal(Condition):
    """Succeeds at its first tick, and whenever ``goal`` or ``goals`` have changed since its last tick, idle or not."""

    INPUTS: ClassVar = GOAL_PORTS

    _known: Any = None

    def update(self) -> Status:
        """Compare the goals with those of the last tick."""
        known, self._known = self._known, goals_of(self)
        return _if(known != self._known or known is None)


class IsGoalNearby(Located, Condition):
    """Succeeds if less than ``proximity_threshold`` of the path remains after its point closest to the robot.

    The search for that point covers the whole path, or ``max_robot_pose_search_dist`` after the previous one. Fails if
    there is no path.
    """

    INPUTS: ClassVar = {
        "path": input_port(PATH, "The path", required=False),
        "proximity_threshold": input_port(FINITE, "Threshold of the remaining length", default=1.0),
        "max_robot_pose_search_dist": input_port(DOUBLE, "Search distance; negative for the whole path", default=-1.0),
        "global_frame": GLOBAL_FRAME,
        "robot_base_frame": BASE_FRAME,
    }

    def __init__(self, name: str, behaviour_class_name: str | None = None) -> None:
        super().__init__(name, behaviour_class_name=behaviour_class_name)
        self._trail = Trail()

    def update(self) -> Status:
        """Compare the remaining length of the path with the threshold."""
        path = self.read("path")
        if path is None or not path.poses:
            self.feedback_message = "there is no path"
            return Status.FAILURE
        ahead = self.read("max_robot_pose_search_dist")
        reached = self._trail.reached(path, self.here, ahead=math.inf if ahead < 0.0 else ahead)
        return _if(length_of(path) - reached < self.read("proximity_threshold"))


class ArePosesNear(Condition):
    """Succeeds if two poses are within ``tolerance`` of each other."""

    INPUTS: ClassVar = {
        "ref_pose": input_port(POSE, "One pose"),
        "target_pose": input_port(POSE, "The other"),
        "tolerance": input_port(FINITE, "Largest distance", default=0.5),
        "global_frame": GLOBAL_FRAME,
    }

    def update(self) -> Status:
        """Compare the distance of the poses with the tolerance."""
        return _if(apart(self.read("ref_pose"), self.read("target_pose")) <= self.read("tolerance"))


FAMILY = Family.of("goals", ArePosesNear, GlobalUpdatedGoal, GoalReached, GoalUpdated, IsGoalNearby)
