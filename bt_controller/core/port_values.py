"""Nodes of XML trees for trees written in Python, with their ports as keyword arguments.

::

    node(IsBatteryLow, min_battery=0.3)
    node(ComputePathToPose, goal="kitchen", path="{path}")
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any, Final, TypeVar

from py_trees.blackboard import Blackboard

from bt_controller.core.node import Control

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.core.node import Node

N = TypeVar("N", bound="Node")

_REFERENCE: Final = re.compile(r"\{(.+)\}")


def node(kind: type[N], /, *children: Behaviour, name: str | None = None, **ports: object) -> N:
    """Create a node of an XML tree and connect its ports.

    Args:
        kind: The node's class.
        *children: Its children; a decorator takes one.
        name: Its name; by default that of its class.
        **ports: Python values, text as in a file, or ``"{key}"`` for an entry of the blackboard.

    Raises:
        ValueError: It has no such port, or a required port has no value.
    """
    create: Any = kind
    name = name or kind.__name__
    result: N = create(name, children=[*children]) if issubclass(kind, Control) else create(name, *children)
    connect(result, **ports)
    return result


def connect(node: Node, /, **ports: object) -> None:
    """Set the ports of a node; call it once.

    Raises:
        ValueError: It has no such port, or a required port has no value.
    """
    known = {**node.INPUTS, **node.OUTPUTS}
    for port in ports:
        if port not in known:
            raise ValueError(f"{node.name}: no port {port!r}; there are {', '.join(known) or 'none'}")
    for port, information in node.INPUTS.items():
        if information.required and information.default_value is None and port not in ports:
            raise ValueError(f"{node.name}: port {port!r} needs a value")
    keys = {port: key for port, value in ports.items() if (key := _key_of(value)) is not None}
    node.setup_ports(keys)
    for port, value in ports.items():
        if port not in keys:
            # A literal value: its key is the node's own.
            Blackboard.set(node.key_of(port), value)


def _key_of(value: object) -> str | None:
    """Return the blackboard key that a value refers to; None for a literal value."""
    match = _REFERENCE.fullmatch(value) if isinstance(value, str) else None
    return match[1] if match else None
