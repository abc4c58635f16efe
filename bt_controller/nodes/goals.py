"""The goals that a tree drives to, as Nav2's nodes look at them: the ports ``goal`` and ``goals``.

Where a file says nothing of these ports, they lead to the keys of their names.
"""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from bt_controller.core.ports import POSE, POSES, input_port

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_controller.core.node import Node
    from bt_controller.core.ports import Port

GOAL_PORTS: Final[Mapping[str, Port]] = MappingProxyType(
    {
        "goal": input_port(POSE, "Where to", default="{goal}", required=False),
        "goals": input_port(POSES, "Where to, one after the other", default="{goals}", required=False),
    }
)


def goals_of(node: Node) -> tuple[Any, Any]:
    """Return the goal and the goals that a node's ports lead to; None for what isn't there."""
    return node.read("goal"), node.read("goals")
