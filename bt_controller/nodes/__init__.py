"""The nodes of XML trees by tag: one folder for each kind, one file for each family.

A family module defines one constant, ``FAMILY``, with the name of its file and its public nodes. Other packages add
theirs through entry points of the group ``bt_controller.nodes.actions``, and so on.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from py_trees.behaviour import Behaviour
from py_trees.ports import PortsMixin

from hmrsim.errors import PluginError
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from types import ModuleType

    from bt_controller.core.node import Node


@dataclass(frozen=True)
class Family:
    """A family of related nodes.

    Attributes:
        name: The name of the file.
    """

    name: str
    nodes: Mapping[str, type[Node]]

    @classmethod
    def of(cls, name: str, *nodes: type[Node]) -> Family:
        """Return a family of classes whose names are their tags."""
        return cls(name, {node.__name__: node for node in nodes})

    @classmethod
    def of_module(cls, module: str, *more: type[Node]) -> Family:
        """Return the family of all public nodes that a module of this package has defined, and of further nodes."""
        return cls.of(module.rpartition(".")[2], *nodes_in(sys.modules[module]).values(), *more)


def nodes_in(module: ModuleType) -> dict[str, type[Any]]:
    """Return the public nodes that a module defines, by name: behaviors with ports."""
    return {
        name: value
        for name, value in vars(module).items()
        if isinstance(value, type) and issubclass(value, PortsMixin) and issubclass(value, Behaviour)
        if hasattr(value, "INPUT_PORTS") and hasattr(value, "OUTPUT_PORTS")
        if value.__module__ == module.__name__ and not name.startswith("_")
    }


UNSUPPORTED: Final[Mapping[str, str]] = MappingProxyType(
    {
        "AssistedTeleop": "teleoperation is not simulated",
        "BlackboardCheckBool": "version 4 has Precondition, and _skipIf for any node",
        "BlackboardCheckDouble": "version 4 has Precondition, and _skipIf for any node",
        "BlackboardCheckInt": "version 4 has Precondition, and _skipIf for any node",
        "BlackboardCheckString": "version 4 has Precondition, and _skipIf for any node",
        "CancelAssistedTeleop": "teleoperation is not simulated",
        "CancelFollowObject": "following objects is not simulated",
        "CheckPoseOccupancy": "there is no costmap; ValidatePath checks the lanes",
        "FollowObject": "following objects is not simulated",
        "IsPoseOccupied": "there is no costmap; ValidatePath checks the lanes",
        "ManualSelector": "it needs a user at a terminal",
        "PauseResumeController": "it needs ROS services; set_simulation_state pauses the simulator",
        "RemoveInCollisionGoals": "there is no costmap; ValidatePath checks the lanes",
        "RetryUntilSuccesful": "version 4 has RetryUntilSuccessful",
        "SequenceStar": "version 4 has SequenceWithMemory",
        "SubTreePlus": 'version 4 has SubTree _autoremap="true"',
    }
)
"""Nodes of other versions and unsupported nodes, with the reason or a remedy."""


@cache
def registry() -> Mapping[str, type[Node]]:
    """Return all nodes by tag.

    Raises:
        PluginError: A module is broken, or two modules define the same tag.
    """
    found: dict[str, type[Node]] = {}
    for kind in ("controls", "decorators", "actions", "conditions"):
        # By name, as they import `Family`.
        package = import_module(f"{__name__}.{kind}")
        for family in discover(package, "FAMILY", Family).values():
            for tag, node in family.nodes.items():
                if tag in found:
                    raise PluginError(f"{package.__name__}.{family.name}: node {tag!r} exists already")
                found[tag] = node
    return found
