"""Operations on subtrees: their paths, and their suspension.

A suspended subtree is not stopped: composites keep their current child, decorators their counts. Only the goals are
canceled, and the parent does not tick the subtree until it resumes it. Then leaves send their unfinished goals again.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any, Final

from bt_controller.core.action_leaf import ActionLeaf
from bt_controller.core.node import MAX_CLASSES

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
    """Return names, of which those that occur more than once are numbered."""
    alike, seen = Counter(names), Counter[str]()
    numbered = []
    for name in names:
        seen[name] += 1
        numbered.append(f"{name}[{seen[name]}]" if alike[name] > 1 else name)
    return numbered


_DRIVES: Final = ("navigate_to_pose", "navigate_through_poses", "follow_waypoints", "dock_robot")


def suspend(root: Behaviour) -> None:
    """Cancel the goals of a subtree and return at once; the caller ticks it again only when it `has_come_to_rest`."""
    for leaf in action_leaves(root):
        leaf.suspend()


def has_come_to_rest(root: Behaviour) -> bool:
    """Return whether no goal of a subtree is active."""
    return not any(leaf.open_goals for leaf in action_leaves(root))


def finds_its_way(root: Behaviour) -> bool:
    """Return whether a suspended subtree resumes with a drive, so that its robot may be anywhere by then."""
    return any(
        leaf.is_unfinished and leaf.action is not None and leaf.action.name in _DRIVES for leaf in action_leaves(root)
    )


def repeat(root: Behaviour) -> None:
    """Make a subtree adopt the active goals of an earlier run and repeat those that have ended."""
    for leaf in action_leaves(root):
        leaf.repeat()


def verdicts(root: Behaviour) -> int:
    """Return the number of goals of a subtree whose end counted, as it did not come from a suspension."""
    return sum(leaf.verdicts for leaf in action_leaves(root))


def behaviors(root: Behaviour) -> list[Behaviour]:
    """Return the behaviors of a tree in the order of py_trees' ``iterate``, children before their parents.

    ``iterate`` is slower: it resumes a generator of each ancestor for each behavior.
    """
    found: list[Behaviour] = []
    todo = [root]
    while todo:
        node = todo.pop()
        found.append(node)
        todo += node.children
    found.reverse()
    return found


def action_leaves(root: Behaviour) -> list[ActionLeaf[Any, Any, Any]]:
    """Return the behaviors of a tree that send goals, in order."""
    nodes: list[Any] = behaviors(root)
    return [node for node in nodes if _sends_goals(node.__class__)]


@lru_cache(MAX_CLASSES)
def _sends_goals(kind: type[Behaviour]) -> bool:
    """Return whether a class is a leaf with goals; cached, since checking the classes of py_trees takes a while."""
    return issubclass(kind, ActionLeaf)
