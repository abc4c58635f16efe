"""A node in a file, checked against its class."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from py_trees.composites import Composite
from py_trees.decorators import Decorator

from bt_controller.xml.keys import is_key, reference
from hmrsim.diagnostics import shown

if TYPE_CHECKING:
    from bt_controller.scripting.parser import Script
    from bt_controller.xml.faults import Origin


@dataclass(frozen=True)
class Call:
    """A node in a file.

    Attributes:
        node: The node's class, with its scripts; None for a subtree.
        tree: The ID of a subtree's tree.
        ports: The ports that the file mentions, each with a ``{key}`` or a value.
        scripts: The scripts of the node's own attributes.
        around: The decoration with the scripts of common attributes such as ``_skipIf``; None if there are none.
        conditions: The scripts of common attributes.
        autoremap: Whether a subtree shares the keys that are not mentioned.
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
    """Return whether a node is of the kind of a long form such as ``<Action ID="…"/>``."""
    if form in ("Action", "Condition"):
        return not issubclass(node, (Composite, Decorator))
    return issubclass(node, Composite if form == "Control" else Decorator)


def children_of(node: type[Any]) -> tuple[int, float]:
    """Return the least and the largest number of a node's children."""
    if issubclass(node, Decorator):
        return 1, 1
    if issubclass(node, Composite):
        return getattr(node, "least", 1), getattr(node, "most", math.inf)
    return 0, 0


def counted(children: int) -> str:
    """Return a number of children as text."""
    return "no children" if children == 0 else "1 child" if children == 1 else f"{children} children"


def connection(node: type[Any], name: str, text: str) -> str:
    """Return the connection of a port: ``{key}``, or a value that the port can parse.

    Raises:
        ValueError: The text is invalid.
    """
    if name in getattr(node, "KEYS", ()) and is_key(text.strip()):
        return f"{{{text.strip()}}}"
    key = reference(name, text)
    if key is not None:
        return f"{{{key}}}"
    if name in node.output_ports():
        raise ValueError(f'{shown(text)} is a value, but the port is an output; use a key: {name}="{{…}}"')
    kind = getattr(node.input_ports()[name], "kind", None)
    if kind is not None:
        kind.read(text, None)
    return text


def shared(name: str, text: str) -> str:
    """Return the connection of a subtree's port: ``{key}``, or a value.

    Raises:
        ValueError: The text is invalid.
    """
    if not is_key(name):
        raise ValueError("not a valid key; expected letters, digits, '_' and '-'")
    key = reference(name, text)
    return text if key is None else f"{{{key}}}"
