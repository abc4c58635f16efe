"""The ports ``goal`` and ``goals``, by which Nav2's nodes read the goals of a tree.

By default they are connected to the keys of the same names.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from bt_controller.core.ports import POSE, POSES, input_port

if TYPE_CHECKING:
    from bt_controller.core.node import Node
    from bt_controller.core.ports import Port

GOAL_PORTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "goal": input_port(POSE, "Destination", default="{goal}", required=False),
        "goals": input_port(POSES, "Destinations in order", default="{goals}", required=False),
    }
)


def goals_of(node: Node) -> tuple[Any, Any]:
    """Return the values of a node's ports ``goal`` and ``goals``; None for a missing one."""
    return node.read("goal"), node.read("goals")
