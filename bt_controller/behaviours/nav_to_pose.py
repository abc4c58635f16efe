"""Drive to a pose."""

from __future__ import annotations

from typing import TYPE_CHECKING

from bt_controller.action_leaf import ActionLeaf
from hmrsim.actions.navigate_to_pose import ACTION
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped
from hmrsim.interfaces.nav2_msgs import NavigateToPose

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_controller.action_leaf import GoalSource


class NavToPoseActionClient(ActionLeaf[NavigateToPose.Goal, NavigateToPose.Result, NavigateToPose.Feedback]):
    """Sends a goal of ``navigate_to_pose``; tells how far the robot still has to go."""

    def __init__(
        self,
        name: str,
        goal: GoalSource[NavigateToPose.Goal],
        *,
        robot: str | None = None,
        on_success: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(name, ACTION, goal, robot=robot, describe=_remaining, on_success=on_success)


def pose_goal(x: float, y: float) -> NavigateToPose.Goal:
    """Return the goal to drive to a point, in the world's unit of length."""
    return NavigateToPose.Goal(pose=PoseStamped(pose=Pose(position=Point(x=x, y=y))))


def _remaining(feedback: NavigateToPose.Feedback) -> str:
    return f"remaining: {feedback.distance_remaining}"
