"""The nodes that a file may use: those of this package and of the user's modules."""

from __future__ import annotations

import inspect
from collections.abc import Iterable
from typing import Any

from py_trees.behaviour import Behaviour
from py_trees.ports import PortsMixin

from bt_controller.errors import TreeError
from bt_controller.imports import imported
from bt_controller.nodes import registry


def vocabulary(modules: Iterable[str] = ()) -> dict[str, type[Any]]:
    """Return all nodes by tag.

    Args:
        modules: The user's modules; each public subclass of Node is a node with its name as the tag.

    Raises:
        TreeError: A module can't be imported, has no nodes, or defines an existing tag.
    """
    found: dict[str, type[Any]] = dict(registry())
    for name in modules:
        module = imported(f"--nodes {name}".rstrip(), name)
        classes = {
            tag: value
            for tag, value in vars(module).items()
            if inspect.isclass(value) and value.__module__ == module.__name__ and _is_node(tag, value)
        }
        if not classes:
            raise TreeError(f"--nodes {name}: it defines no nodes, public subclasses of bt_controller.core.node.Node")
        for tag, value in classes.items():
            if found.setdefault(tag, value) is not value:
                where = found[tag].__module__
                raise TreeError(f"--nodes {name}: node {tag!r} exists already, in {where}; rename the class")
    return found


def _is_node(tag: str, value: type[Any]) -> bool:
    has_ports = hasattr(value, "INPUT_PORTS") and hasattr(value, "OUTPUT_PORTS")
    return not tag.startswith("_") and has_ports and issubclass(value, PortsMixin) and issubclass(value, Behaviour)
