"""A node as a file uses it, and what its class allows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from py_trees.composites import Composite
from py_trees.decorators import Decorator

from bt_controller.xml.keys import is_key, reference
from hmrsim.diagnostics import shown

if TYPE_CHECKING:
    from collections.abc import Mapping

    from bt_controller.scripting.parser import Script
    from bt_controller.xml.faults import Origin


@dataclass(frozen=True)
class Call:
    """A node as the file uses it.

    Attributes:
        origin: Where.
        node: Its class, with its scripts; None for a subtree.
        tree: The ID of a subtree's tree.
        ports: What each port that the file mentions is connected with: ``{key}``, or a value.
        scripts: Those that are the node's own.
        around: The decoration with the scripts that any node may have; None if it has none.
        conditions: Those scripts.
        autoremap: Whether a subtree shares the keys that are not mentioned.
        children: In order.
    """

    origin: Origin
    node: type[Any] | None
    tree: str
    ports: Mapping[str, str]
    scripts: Mapping[str, Script]
    around: type[Any] | None
    conditions: Mapping[str, Script]
    autoremap: bool
    children: tuple[Call, ...] = ()


def is_a(node: type[Any], form: str) -> bool:
    """Return whether a node is of the kind that a long form says, such as ``<Action ID="…"/>``."""
    if form in ("Action", "Condition"):
        return not issubclass(node, (Composite, Decorator))
    return issubclass(node, Composite if form == "Control" else Decorator)


def children_of(node: type[Any]) -> tuple[int, float]:
    """Return how many children a node has at least and at most."""
    if issubclass(node, Decorator):
        return 1, 1
    if issubclass(node, Composite):
        return getattr(node, "least", 1), getattr(node, "most", math.inf)
    return 0, 0


def counted(children: int) -> str:
    """Return how many children there are, in words."""
    return "no children" if children == 0 else "1 child" if children == 1 else f"{children} children"


def connection(node: type[Any], name: str, text: str) -> str:
    """Return what a port is connected with: ``{key}``, or a value that it can read.

    Raises:
        ValueError: It can't be.
    """
    if name in getattr(node, "KEYS", ()) and is_key(text.strip()):
        return f"{{{text.strip()}}}"
    key = reference(name, text)
    if key is not None:
        return f"{{{key}}}"
    if name in node.output_ports():
        raise ValueError(f'{shown(text)} is a value, and this is an output; write {name}="{{…}}"')
    kind = getattr(node.input_ports()[name], "kind", None)
    if kind is not None:
        kind.read(text, None)
    return text


def shared(name: str, text: str) -> str:
    """Return what a port of a subtree is connected with: ``{key}``, or a value.

    Raises:
        ValueError: It can't be.
    """
    if not is_key(name):
        raise ValueError("that is no name of a key; letters, digits, '_' and '-' are expected")
    key = reference(name, text)
    return text if key is None else f"{{{key}}}"
