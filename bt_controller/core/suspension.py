"""Suspending a subtree, and resuming it.

No behavior is stopped: composites keep their current child, decorators their counts. Only the goals are canceled, and
the parent does not tick the subtree until it resumes it; then leaves send their unfinished goals again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from bt_controller.core.action_leaf import ActionLeaf

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

_DRIVES: Final = ("navigate_to_pose", "navigate_through_poses", "follow_waypoints", "dock_robot")


def suspend(root: Behaviour) -> None:
    """Cancel the goals of a subtree and return at once. The caller ticks it again only when it `has_come_to_rest`."""
    for leaf in _leaves(root):
        leaf.suspend()


def has_come_to_rest(root: Behaviour) -> bool:
    """Return whether no goal of a subtree is active."""
    return not any(leaf.open_goals for leaf in _leaves(root))


def finds_its_way(root: Behaviour) -> bool:
    """Return whether a suspended subtree resumes with a drive, which may start anywhere."""
    return any(leaf.is_unfinished and leaf.action is not None and leaf.action.name in _DRIVES for leaf in _leaves(root))


def repeat(root: Behaviour) -> None:
    """Let a subtree adopt the active goals of an earlier run and repeat those that have ended."""
    for leaf in _leaves(root):
        leaf.repeat()


def verdicts(root: Behaviour) -> int:
    """Return the number of a subtree's goals whose end counted."""
    return sum(leaf.verdicts for leaf in _leaves(root))


def _leaves(root: Behaviour) -> list[ActionLeaf[Any, Any, Any]]:
    return [node for node in root.iterate() if isinstance(node, ActionLeaf)]
