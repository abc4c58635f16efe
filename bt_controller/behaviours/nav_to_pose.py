"""Behaviors that drive to a pose or a place."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.world.directory import NotServed
from hmrsim.actions.navigate_to_pose import ACTION
from hmrsim.diagnostics import shown
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim_zenoh.client.places import pose_at

if TYPE_CHECKING:
    from bt_controller.core.action_leaf import GoalSource


_LENGTHS: Final = (2, 3)
"""Of x and y, and of yaw beside."""


class NavToPoseActionClient(ActionLeaf[NavigateToPose.Goal, NavigateToPose.Result, NavigateToPose.Feedback]):
    """Sends a goal of ``navigate_to_pose``; its feedback message is the remaining distance."""

    def __init__(
        self,
        name: str,
        goal: GoalSource[NavigateToPose.Goal],
        *,
        robot: str | None = None,
        on_success: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(name, ACTION, goal, robot=robot, describe=_remaining, on_success=on_success)


class GoTo(NavToPoseActionClient):
    """Drives the robot to a place of the world: a waypoint, a place or a dock; or to a pose.

    ::

        GoTo("pharmacy")
        GoTo((6.0, 18.0), name="Go to the pharmacy")

    Args:
        target: The place's name; or x, y and, if it matters, yaw, in the world's unit of length and radians.
        name: The behavior's name; says the target if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.

    Raises:
        TypeError: The target is neither.
    """

    def __init__(
        self,
        target: str | tuple[float, float] | tuple[float, float, float],
        *,
        name: str | None = None,
        robot: str | None = None,
    ) -> None:
        if not isinstance(target, str) and not (isinstance(target, Sequence) and len(target) in _LENGTHS):
            raise TypeError(f"GoTo takes the name of a place, (x, y) or (x, y, yaw), got {shown(target)}")
        self._place = target if isinstance(target, str) else None
        words = target if isinstance(target, str) else "({})".format(", ".join(f"{part:g}" for part in target))
        goal = None if isinstance(target, str) else NavigateToPose.Goal(pose=pose_at(*target))
        super().__init__(name or f"Go to {words}", lambda: goal, robot=robot)

    def setup(self, **kwargs: Any) -> None:
        """Look up the action and the place.

        Raises:
            NotServed: There is no such robot, action or place.
            SimulatorNotFound: No simulator answers.
        """
        super().setup(**kwargs)
        if self._place is not None:
            try:
                self._goal = NavigateToPose.Goal(pose=kwargs["places"].pose(self._place))
            except ValueError as error:
                raise NotServed(f"{self.name!r}: {error}") from None


def pose_goal(x: float, y: float) -> NavigateToPose.Goal:
    """Return the goal of a drive to a point, in the world's unit of length."""
    return NavigateToPose.Goal(pose=pose_at(x, y))


def _remaining(feedback: NavigateToPose.Feedback) -> str:
    return f"remaining: {feedback.distance_remaining}"
