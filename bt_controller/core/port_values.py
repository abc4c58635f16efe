"""Nodes of XML trees in trees that are written in Python: ports by keyword.

::

    node(IsBatteryLow, min_battery=0.3)
    node(ComputePathToPose, goal="kitchen", path="{path}")
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final, TypeVar

from py_trees.blackboard import Blackboard

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.core.node import Node

N = TypeVar("N", bound="Node")

_REFERENCE: Final = re.compile(r"\{(.+)\}")


def node(kind: type[N], *children: Behaviour, name: str | None = None, **ports: object) -> N:
    """Return a node of an XML tree with the values of its ports.

    Args:
        kind: Its class.
        *children: Its children, if it takes any; a decorator takes one.
        name: Its name; that of its class if left out.
        **ports: The ports' values: Python values, text as in a file, or ``"{key}"`` for an entry of the blackboard.

    Raises:
        ValueError: It has no such port, or lacks one.
    """
    made: Any = kind
    shown = name or kind.__name__
    many = hasattr(kind, "least")
    built: N = made(shown, children=list(children)) if many else made(shown, *children)
    connect(built, **ports)
    return built


def connect(built: Node, **ports: object) -> None:
    """Set the ports of a node, once.

    Raises:
        ValueError: It has no such port, or lacks one.
    """
    known = {**built.INPUTS, **built.OUTPUTS}
    for port in ports:
        if port not in known:
            raise ValueError(f"{built.name}: no port {port!r}; there are {', '.join(known) or 'none'}")
    for port, information in built.INPUTS.items():
        if information.required and information.default_value is None and port not in ports:
            raise ValueError(f"{built.name}: port {port!r} needs a value")
    keys = {port: key for port, value in ports.items() if (key := _key_of(value)) is not None}
    built.setup_ports(keys)
    for port, value in ports.items():
        if port not in keys:
            # Its key is one that no other node has.
            Blackboard.set(built.key_of(port), value)


def _key_of(value: object) -> str | None:
    """Return the blackboard key that a value refers to; None if it is one itself."""
    match = _REFERENCE.fullmatch(value) if isinstance(value, str) else None
    return match[1] if match else None
