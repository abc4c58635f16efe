"""The nodes that XML trees are made of, by tag: one folder a kind, one file a family.

A family module defines one constant, ``FAMILY``, named as its file. Others add theirs through entry points of the
group ``bt_controller.nodes.actions``, and so on.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from importlib import import_module
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.errors import PluginError
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_controller.core.node import Node


@dataclass(frozen=True)
class Family:
    """Nodes that belong together.

    Attributes:
        name: As its file.
        nodes: By the tag that they have in files.
    """

    name: str
    nodes: Mapping[str, type[Node]]


UNSUPPORTED: Final[Mapping[str, str]] = MappingProxyType(
    {
        "AssistedTeleop": "nobody steers robots by hand here",
        "BlackboardCheckBool": "version 4 has Precondition, and _skipIf for any node",
        "BlackboardCheckDouble": "version 4 has Precondition, and _skipIf for any node",
        "BlackboardCheckInt": "version 4 has Precondition, and _skipIf for any node",
        "BlackboardCheckString": "version 4 has Precondition, and _skipIf for any node",
        "CancelAssistedTeleop": "nobody steers robots by hand here",
        "CancelComputeAndTrackRoute": "there is no route server here; ComputePathToPose plans along the lanes",
        "CancelFollowObject": "robots here don't follow objects",
        "CheckPoseOccupancy": "there is no costmap here; ValidatePath looks at the lanes",
        "ComputeAndTrackRoute": "there is no route server here; ComputePathToPose plans along the lanes",
        "ComputePathThroughPoses": "robots here plan to one pose: ComputePathToPose; or drive: NavigateThroughPoses",
        "ComputeRoute": "there is no route server here; ComputePathToPose plans along the lanes",
        "ExtractRouteNodesAsGoals": "there is no route server here; ComputePathToPose plans along the lanes",
        "FollowObject": "robots here don't follow objects",
        "IsPoseOccupied": "there is no costmap here; ValidatePath looks at the lanes",
        "IsWithinPathTrackingBounds": "robots here are never off their path",
        "ManualSelector": "it would ask a person at a terminal",
        "PauseResumeController": "it waits for ROS services; set_simulation_state pauses the simulator",
        "RemoveInCollisionGoals": "there is no costmap here; ValidatePath looks at the lanes",
        "RetryUntilSuccesful": "version 4 has RetryUntilSuccessful",
        "SequenceStar": "version 4 has SequenceWithMemory",
        "SmoothPath": "robots here don't smooth paths",
        "SubTreePlus": 'version 4 has SubTree _autoremap="true"',
        "WouldARouteRecoveryHelp": "there is no route server here; ComputePathToPose plans along the lanes",
    }
)
"""Nodes of other versions, or that can't be, and what to do."""


@cache
def registry() -> Mapping[str, type[Node]]:
    """Return all nodes by tag.

    Raises:
        PluginError: A module is broken, or two have nodes of one tag.
    """
    found: dict[str, type[Node]] = {}
    for kind in ("controls", "decorators", "actions", "conditions"):
        # By name, as they import `Family`.
        package = import_module(f"{__name__}.{kind}")
        for family in discover(package, "FAMILY", Family).values():
            for tag, node in family.nodes.items():
                if tag in found:
                    raise PluginError(f"{package.__name__}.{family.name}: there is a node {tag!r} already")
                found[tag] = node
    return found
