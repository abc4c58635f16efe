"""Behaviour trees that drive robots from outside: a client of the simulator, in a process of its own.

What is exported is for those who write trees in Python: leaves that send a robot somewhere or have it do something, and
the classes from which nodes of one's own, for XML trees too, are made. It is loaded when it is first used.
"""

from __future__ import annotations

import importlib
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from bt_controller.behaviours.battery_guard import BatteryGuard
    from bt_controller.behaviours.docks import Dock, Undock
    from bt_controller.behaviours.items import Pickup, Place
    from bt_controller.behaviours.nav_to_pose import GoTo
    from bt_controller.behaviours.wait import Wait
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
        "Dock": "behaviours.docks",
        "GoTo": "behaviours.nav_to_pose",
        "Leaf": "core.node",
        "Node": "core.node",
        "Pickup": "behaviours.items",
        "Place": "behaviours.items",
        "Undock": "behaviours.docks",
        "Wait": "behaviours.wait",
    }
)
"""The module of each."""


def __getattr__(name: str) -> object:
    """Load what is exported when it is asked for (PEP 562)."""
    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(importlib.import_module(f"{__name__}.{_HOMES[name]}"), name)
