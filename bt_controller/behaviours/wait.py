"""A behavior that keeps the robot in place."""

from __future__ import annotations

from bt_controller.behaviours.action_clients import FromConstant
from hmrsim.actions.wait import ACTION
from hmrsim.interfaces import nav2_msgs
from hmrsim.interfaces.builtin_interfaces import Duration


class Wait(FromConstant[nav2_msgs.Wait.Goal, nav2_msgs.Wait.Result, nav2_msgs.Wait.Feedback]):
    """Keeps the robot in place for a time, for instance while it works there.

    Args:
        seconds: Simulated seconds.
        name: The behavior's name; says how long if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.
    """

    def __init__(self, seconds: float, *, name: str | None = None, robot: str | None = None) -> None:
        goal = nav2_msgs.Wait.Goal(time=Duration.from_seconds(seconds))
        super().__init__(name or f"Wait {seconds:g} s", ACTION, goal, robot=robot)
