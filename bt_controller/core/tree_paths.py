"""The paths of a tree's behaviors: the names from the root to each of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


def paths(root: Behaviour) -> Iterator[tuple[Behaviour, str]]:
    """Yield all behaviors with the names from the root to each; siblings of one name are numbered, from 1."""
    todo = [(root, root.name)]
    while todo:
        node, path = todo.pop()
        yield node, path
        names = [child.name for child in node.children]
        if len(names) != len({*names}):
            names = _numbered(names)
        todo += [*zip(node.children, [f"{path}/{name}" for name in names], strict=True)][::-1]


def _numbered(names: Sequence[str]) -> list[str]:
    """Return names with their numbers, of those that are there more than once."""
    alike, seen = Counter(names), Counter[str]()
    numbered = []
    for name in names:
        seen[name] += 1
        numbered.append(f"{name}[{seen[name]}]" if alike[name] > 1 else name)
    return numbered
