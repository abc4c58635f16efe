"""Behaviors that pick items up and put them down."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from bt_controller.core.action_leaf import ActionLeaf
from hmrsim.actions import pickup, place
from hmrsim.interfaces import moveit_msgs
from hmrsim.interfaces.message import unbuilt


class Pickup(ActionLeaf[Any, moveit_msgs.Pickup.Result, moveit_msgs.Pickup.Feedback]):
    """Picks up an item that is in reach.

    Args:
        name: The behavior's name; says the item if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.

    Raises:
        TypeError: The item's name is no text.
    """

    PLAIN = True

    def __init__(self, item: str, *, name: str | None = None, robot: str | None = None) -> None:
        def goal() -> Mapping[str, Any]:
            return unbuilt(moveit_msgs.Pickup.Goal, target_name=item)

        super().__init__(name or f"Pick up {_checked(item)}", pickup.ACTION, goal, robot=robot)


class Place(ActionLeaf[Any, moveit_msgs.Place.Result, moveit_msgs.Place.Feedback]):
    """Puts down an item that the robot holds.

    Args:
        name: The behavior's name; says the item if left out.
        robot: The robot that serves the action; None for the one that the tree is run for.

    Raises:
        TypeError: The item's name is no text.
    """

    PLAIN = True

    def __init__(self, item: str, *, name: str | None = None, robot: str | None = None) -> None:
        def goal() -> Mapping[str, Any]:
            return unbuilt(moveit_msgs.Place.Goal, attached_object_name=item)

        super().__init__(name or f"Place {_checked(item)}", place.ACTION, goal, robot=robot)


def _checked(item: object) -> object:
    if not isinstance(item, str):
        raise TypeError(f"{item!r} is no item's name; a text is expected")
    return item
