"""Leaves for any action, named as in py_trees_ros: the goal is constant or read from the blackboard."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

from bt_controller.core.action_leaf import ActionLeaf
from hmrsim.actions import F, G, R

if TYPE_CHECKING:
    from hmrsim.actions import Action


class FromConstant(ActionLeaf[G, R, F]):
    """A leaf that sends a constant goal.

    Args:
        generate_feedback_message: Formats feedback as the feedback message; None for its plain fields.
        robot: The robot that serves the action; None for the robot that the tree is run for.
        on_success: Values to write on the blackboard when the goal has succeeded, by key.

    Raises:
        ValueError: There is no action of this name.
        TypeError: The goal is of another action.
    """

    def __init__(
        self,
        name: str,
        action: Action[G, R, F] | str,
        goal: G,
        generate_feedback_message: Callable[[F], str] | None = None,
        *,
        robot: str | None = None,
        on_success: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(name, action, goal, robot=robot, describe=generate_feedback_message, on_success=on_success)
        if self.action is not None and not isinstance(goal, self.action.goal):
            raise TypeError(f"{name!r}: {self.action.name} takes {self.action.goal.ros_type}, got {goal!r}")


class FromBlackboard(ActionLeaf[G, R, F]):
    """A leaf that sends the goal that is on the blackboard upon initialise; fails if there is none.

    A preceding `WaitForBlackboardVariable` of py_trees waits for one.

    Args:
        key: The goal's blackboard key.
        generate_feedback_message: Formats feedback as the feedback message; None for its plain fields.
        robot: The robot that serves the action; None for the one that the tree is run for.
        on_success: Values to write on the blackboard when the goal has succeeded, by key.

    Raises:
        ValueError: There is no action of this name.
    """

    def __init__(
        self,
        name: str,
        action: Action[G, R, F] | str,
        key: str,
        generate_feedback_message: Callable[[F], str] | None = None,
        *,
        robot: str | None = None,
        on_success: Mapping[str, object] | None = None,
    ) -> None:
        super().__init__(name, action, key, robot=robot, describe=generate_feedback_message, on_success=on_success)
