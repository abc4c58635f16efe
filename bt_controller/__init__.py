"""Behavior trees that control robots: a client of the simulator in a separate process.

The exports serve authors of trees in Python: leaves for the robots' actions, and base classes for custom nodes, also of
XML trees. Each export is loaded when it is first used.
"""

from __future__ import annotations

import importlib
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bt_controller.behaviours.battery_guard import BatteryGuard
    from bt_controller.behaviours.robot_actions import Dock, GoTo, Pickup, Place, Undock, Wait
    from bt_controller.core.action_leaf import ActionLeaf
    from bt_controller.core.action_node import ActionNode
    from bt_controller.core.node import Condition, Control, Decoration, Leaf, Node

__all__ = [
    "ActionLeaf",
    "ActionNode",
    "BatteryGuard",
    "Condition",
    "Control",
    "Decoration",
    "Dock",
    "GoTo",
    "Leaf",
    "Node",
    "Pickup",
    "Place",
    "Undock",
    "Wait",
]

_HOMES = MappingProxyType(
    {
        "ActionLeaf": "core.action_leaf",
        "ActionNode": "core.action_node",
        "BatteryGuard": "behaviours.battery_guard",
        "Condition": "core.node",
        "Control": "core.node",
        "Decoration": "core.node",
        "Dock": "behaviours.robot_actions",
        "GoTo": "behaviours.robot_actions",
        "Leaf": "core.node",
        "Node": "core.node",
        "Pickup": "behaviours.robot_actions",
        "Place": "behaviours.robot_actions",
        "Undock": "behaviours.robot_actions",
        "Wait": "behaviours.robot_actions",
    }
)
"""The module of each export."""


def __getattr__(name: str) -> object:
    """Load an export on first access (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
