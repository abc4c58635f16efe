"""The tree of a file, read and checked once and built for each robot, and the nodes that a file may use."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from py_trees.behaviour import Behaviour
from py_trees.blackboard import Blackboard
from py_trees.ports import PortsMixin

from bt_controller.core.blackboards import Board
from bt_controller.errors import TreeError
from bt_controller.loading.builder import check_subtrees, plan
from bt_controller.loading.check import check
from bt_controller.loading.document import document
from bt_controller.loading.named_functions import imported
from bt_controller.loading.source import Element, Faults, read
from bt_controller.loading.wiring import examine, unread
from bt_controller.nodes import registry
from hmrsim.file_cache import FileCache
from hmrsim.program.users_code import described

if TYPE_CHECKING:
    from bt_controller.loading.builder import Blueprint


@dataclass(frozen=True)
class FileTree:
    """A tree of a file.

    Attributes:
        blueprint: Its root.
        texts: The initial blackboard entries of its subtrees.
        files: The files that it was read from.
    """

    blueprint: Blueprint
    texts: Mapping[str, str]
    files: tuple[str, ...]

    def build(self) -> Behaviour:
        """Return the root of a new tree, on the blackboard in use."""
        for key, text in self.texts.items():
            Blackboard.set(key, text)
        root: Behaviour = self.blueprint.build()
        return root


def load_file(
    path: str, nodes: Mapping[str, type[Any]], *, tree: str | None, values: Mapping[str, str]
) -> tuple[FileTree, tuple[str, ...], tuple[str, ...]]:
    """Return the tree of a file, a line for each required port that nothing writes, and one for each warning.

    Args:
        path: The file.
        nodes: The known nodes by tag.
        tree: The ID of the tree to run; None for the file's main tree.
        values: The initial texts on each blackboard.

    Raises:
        TreeError: The file is invalid; the text has one line for each error.
    """
    key = (path, Path(path).absolute(), frozenset(nodes.items()), tree, frozenset(values.items()))
    # To check a tree takes ten times as long as to build it.
    return _LOADED.get(key, partial(_load, path, nodes, tree, values), lambda loaded: loaded.result.files)


class _Loaded(NamedTuple):
    """A tree as it was loaded."""

    result: FileTree
    unset: tuple[str, ...]
    warnings: tuple[str, ...]


_LOADED: Final[FileCache[_Loaded]] = FileCache()


def _load(path: str, nodes: Mapping[str, type[Any]], tree: str | None, values: Mapping[str, str]) -> _Loaded:
    root = read(path)
    faults = Faults()
    found = document(root, faults, tree=tree)
    calls = check(found, nodes, faults)
    check_subtrees(calls, faults)
    faults.raise_any()
    files = dict.fromkeys(element.origin.file for element in root.iter() if isinstance(element, Element))
    result = FileTree(*plan(found.main, calls), tuple(files))
    unset, unknown = _tried(path, result, values, faults)
    faults.raise_any()
    return _Loaded(result, unset, (*faults.warnings, *unknown))


def _tried(
    path: str, tree: FileTree, values: Mapping[str, str], faults: Faults
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Build a tree and check it for keys that nothing writes or nothing reads."""
    with Board().in_use():
        for key, text in values.items():
            Blackboard.set(key, text)
        try:
            root = tree.build()
        except TreeError as error:
            raise TreeError(f"{path}: {error}") from error
        except Exception as error:  # such as a value that its port does not take
            raise TreeError(f"{path}: {described(error)}") from error
        # A guard adds a drive back, which no file names.
        nodes = [node for node in root.iterate() if not getattr(node, "implied", False)]
        unset = examine(zip(nodes, tree.blueprint.origins(), strict=True), faults)
        return unset, unread(values)


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
