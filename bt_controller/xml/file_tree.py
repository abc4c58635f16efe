"""The tree of a file: read and checked once, made for each robot."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from py_trees.blackboard import Blackboard

from bt_controller.core.blackboards import Board
from bt_controller.errors import TreeError
from bt_controller.xml.check import check
from bt_controller.xml.document import document
from bt_controller.xml.draft import drafted
from bt_controller.xml.faults import Faults
from bt_controller.xml.source import Element, read
from bt_controller.xml.translation import SUBTREE, in_order, translate
from bt_controller.xml.wiring import examine, unread
from hmrsim.file_cache import FileCache
from hmrsim.program.users_code import described

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.xml.draft import Draft
    from bt_controller.xml.faults import Origin
    from bt_controller.xml.translation import Translation


@dataclass(frozen=True)
class FileTree:
    """A tree of a file.

    Attributes:
        draft: What py_trees has read.
        labels: The name and the origin of each node, in the order of py_trees' ``iterate``.
        texts: The initial blackboard entries of its subtrees.
        files: The files that it was read from.
    """

    draft: Draft
    labels: tuple[tuple[str, Origin], ...]
    texts: Mapping[str, str]
    files: tuple[str, ...]

    def build(self) -> Behaviour:
        """Return the root of a new tree, on the blackboard in use."""
        for key, text in self.texts.items():
            Blackboard.set(key, text)
        root: Behaviour = self.draft.made()
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
        TreeError: The file is invalid; the text has one line for each mistake.
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
    in_order(calls, faults)
    faults.raise_any()
    translation = translate(calls, faults)
    faults.raise_any()
    files = dict.fromkeys(element.origin.file for element in root.iter() if isinstance(element, Element))
    try:
        result = _labelled(found.main, translation, tuple(files))
    except Exception as error:  # whatever py_trees' parser can't take
        raise TreeError(f"{path}: {described(error)}") from error
    unset, unknown = _tried(path, result, values, faults)
    faults.raise_any()
    return _Loaded(result, unset, (*faults.warnings, *unknown))


def _labelled(main: str, translation: Translation, files: tuple[str, ...]) -> FileTree:
    labels = []
    texts = {}
    for part, namespace in translation.parts(main):
        if part.tag == SUBTREE:
            texts.update({f"{namespace}{key}": text for key, text in part.texts.items()})
        else:
            labels.append((part.shown, part.origin))
    draft = drafted(main, translation)
    drafts: Iterable[Any] = draft.iterate()
    for each, (name, origin) in zip(drafts, labels, strict=True):
        each.label(name, str(origin))
    return FileTree(draft, tuple(labels), texts, files)


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
        except Exception as error:  # such as a value that is none of its port's
            raise TreeError(f"{path}: {described(error)}") from error
        unset = examine(zip(_named(root), (origin for _, origin in tree.labels), strict=True), faults)
        return unset, unread(values)


def _named(root: Behaviour) -> list[Behaviour]:
    """Return the nodes of the file, without the drive back that a guard adds."""
    return [node for node in root.iterate() if not getattr(node, "implied", False)]
