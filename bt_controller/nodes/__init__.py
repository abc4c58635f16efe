"""The nodes that XML trees are made of, by tag: one folder a kind, one file a family.

A family module defines one constant, ``FAMILY``, named as its file. Others add theirs through entry points of the
group ``bt_controller.nodes.actions``, and so on.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING

from hmrsim.errors import PluginError
from hmrsim.plugins import discover

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_controller.node import Node


@dataclass(frozen=True)
class Family:
    """Nodes that belong together.

    Attributes:
        name: As its file.
        nodes: By the tag that they have in files.
    """

    name: str
    nodes: Mapping[str, type[Node]]


@cache
def registry() -> Mapping[str, type[Node]]:
    """Return all nodes by tag.

    Raises:
        PluginError: A module is broken, or two have nodes of one tag.
    """
    from bt_controller.nodes import actions, conditions, controls, decorators  # noqa: PLC0415 - they import `Family`

    found: dict[str, type[Node]] = {}
    for package in (controls, decorators, actions, conditions):
        for family in discover(package, "FAMILY", Family).values():
            for tag, node in family.nodes.items():
                if tag in found:
                    raise PluginError(f"{package.__name__}.{family.name}: there is a node {tag!r} already")
                found[tag] = node
    return found
