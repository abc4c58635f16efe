"""A node in a file, checked against its class, and its references to the blackboard.

A reference is ``{key}``, ``{=}`` for the port's own name, or ``{@key}`` for the main tree's entry.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from py_trees.composites import Composite
from py_trees.decorators import Decorator
from py_trees.ports import CONST_PREFIX, DOT_REPLACEMENT

from hmrsim.diagnostics import shown

if TYPE_CHECKING:
    from bt_controller.loading.source import Origin
    from bt_controller.scripting.parser import Script


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


_KEY: Final = re.compile(r"@?[\w-]+")
_TAKEN: Final = ("name", "ID", "@name", "@ID")
"""The attributes that py_trees reserves."""


def reference(port: str, text: str) -> str | None:
    """Return the key that a text refers to; None if it is a value.

    Raises:
        ValueError: The text is neither, or has a special meaning in py_trees.
    """
    inner = text.strip()
    if not (inner.startswith("{") and inner.endswith("}") and len(inner) > len("{}")):
        if "{" in text or "}" in text:
            raise ValueError(f"{shown(text)} is not a value; braces enclose keys of the blackboard: {{key}}")
        if CONST_PREFIX in text or DOT_REPLACEMENT in text:
            raise ValueError(
                f"{shown(text)} is not a value; {CONST_PREFIX!r} and {DOT_REPLACEMENT!r} are reserved by py_trees"
            )
        return None
    key = port if inner == "{=}" else inner[1:-1].strip()
    if not is_key(key):
        wanted = "the name is reserved" if key in _TAKEN else "expected letters, digits, '_' and '-'"
        raise ValueError(f"{shown(text)} is not a key of the blackboard; {wanted}")
    return key


def is_key(text: str) -> bool:
    """Return whether a text can be a key."""
    return (
        bool(_KEY.fullmatch(text)) and text not in _TAKEN and CONST_PREFIX not in text and DOT_REPLACEMENT not in text
    )
