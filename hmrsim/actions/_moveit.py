"""Common parts of MoveIt's actions: the error codes that the dispatcher needs, and items as script orders name them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.actions import Codes
from hmrsim.diagnostics import known_name
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes

if TYPE_CHECKING:
    from hmrsim.world.model import World

CODES = Codes(
    canceled=MoveItErrorCodes.PREEMPTED,
    preempted=MoveItErrorCodes.PREEMPTED,
    rejected=MoveItErrorCodes.FAILURE,
    unknown=MoveItErrorCodes.FAILURE,
    busy=MoveItErrorCodes.INVALID_ROBOT_STATE,
)


def item_ordered(text: str, world: World) -> str:
    """Return the item that an order names.

    Raises:
        ValueError: There is no such item.
    """
    return known_name("item", text, world.items)
