"""Letting a subtree stand still where it is, and go on from there.

Nothing in it is stopped: composites keep their place, decorators their counts. Only its goals are canceled, and
whoever let it stand still does not tick it until it is to go on; then leaves send again what was not done.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

from bt_controller.core.action_leaf import ActionLeaf

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

_DRIVES: Final = ("navigate_to_pose", "navigate_through_poses", "follow_waypoints", "dock_robot")


def suspend(root: Behaviour) -> None:
    """Cancel the goals of a subtree; returns at once. Tick it again only when it `has_come_to_rest`."""
    for leaf in _leaves(root):
        leaf.suspend()


def has_come_to_rest(root: Behaviour) -> bool:
    """Return whether no goal of a subtree is under way."""
    return not any(leaf.open_goals for leaf in _leaves(root))


def finds_its_way(root: Behaviour) -> bool:
    """Return whether a suspended subtree goes on with a drive to somewhere, from wherever the robot is then."""
    return any(leaf.is_unfinished and leaf.action is not None and leaf.action.name in _DRIVES for leaf in _leaves(root))


def repeat(root: Behaviour) -> None:
    """Let a subtree that is set up take over what is under way from an earlier life, and do anew what has ended."""
    for leaf in _leaves(root):
        leaf.repeat()


def verdicts(root: Behaviour) -> int:
    """Return how many goals of a subtree have come to an end that counted for it."""
    return sum(leaf.verdicts for leaf in _leaves(root))


def _leaves(root: Behaviour) -> list[ActionLeaf[Any, Any, Any]]:
    return [node for node in root.iterate() if isinstance(node, ActionLeaf)]
