"""Behaviours that pick items up and put them down."""

from __future__ import annotations

from bt_controller.behaviours.action_clients import FromConstant
from hmrsim.actions import pickup, place
from hmrsim.interfaces import moveit_msgs


class Pickup(FromConstant[moveit_msgs.Pickup.Goal, moveit_msgs.Pickup.Result, moveit_msgs.Pickup.Feedback]):
    """Picks up an item that is in reach.

    Args:
        name: The behaviour's name; says the item if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.
    """

    def __init__(self, item: str, *, name: str | None = None, robot: str | None = None) -> None:
        super().__init__(
            name or f"Pick up {item}", pickup.ACTION, moveit_msgs.Pickup.Goal(target_name=item), robot=robot
        )


class Place(FromConstant[moveit_msgs.Place.Goal, moveit_msgs.Place.Result, moveit_msgs.Place.Feedback]):
    """Puts down an item that the robot holds.

    Args:
        name: The behaviour's name; says the item if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.
    """

    def __init__(self, item: str, *, name: str | None = None, robot: str | None = None) -> None:
        super().__init__(
            name or f"Place {item}", place.ACTION, moveit_msgs.Place.Goal(attached_object_name=item), robot=robot
        )
