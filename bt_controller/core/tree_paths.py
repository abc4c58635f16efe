"""The paths of a tree's behaviours: the names from the root to each of them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour


def paths(root: Behaviour) -> Iterator[tuple[Behaviour, str]]:
    """Yield all behaviours with the names from the root to each; siblings of one name are numbered, from 1."""
    yield from _below(root, root.name)


def _below(node: Behaviour, path: str) -> Iterator[tuple[Behaviour, str]]:
    yield node, path
    if not node.children:
        return
    alike = Counter(child.name for child in node.children)
    seen: Counter[str] = Counter()
    for child in node.children:
        seen[child.name] += 1
        number = f"[{seen[child.name]}]" if alike[child.name] > 1 else ""
        yield from _below(child, f"{path}/{child.name}{number}")
