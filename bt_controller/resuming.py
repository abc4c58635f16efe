"""Going on where a controller was when it ended: each goal has the same id in each of its lives.

A restarted controller walks its tree from the beginning. What was done, or is under way, the simulator knows by its
id already: the leaf takes it over instead of doing it again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim.actions import error_of
from hmrsim.goal import GoalStatus, made_goal_id
from hmrsim_zenoh.errors import ResultExpired

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from bt_controller.action_leaf import ActionLeaf
    from hmrsim_zenoh.goal_handle import GoalHandle


class Resumption:
    """The ids of a leaf's goals, by its mission, its place in the tree, and which of its goals it is.

    Args:
        mission: Whose goals they are: participant, mission and robot.
        leaf: Whose; in its tree already.

    Attributes:
        latest: The goal that was sent last.
    """

    def __init__(self, mission: str, leaf: ActionLeaf[Any, Any, Any]) -> None:
        self._leaf = leaf
        self._owner = f"{mission}/{place_of(leaf)}"
        self._number = 0
        self.latest: GoalHandle[Any, Any] | None = None

    def next_id(self) -> str:
        """Return the id of the next goal.

        One that was rejected, or of which nobody heard, was never begun as far as we know: the next has its id. So
        the ids of those that were begun have no gaps, and the next life finds them one after the other.
        """
        latest = self.latest
        if latest is None or latest.error is None or isinstance(latest.error, ResultExpired):
            self._number += 1
        return self._id(self._number)

    def is_undone(self, handle: GoalHandle[Any, Any]) -> bool:
        """Return whether a goal of an earlier life has ended so that the next one of the leaf tells more.

        That is if it was canceled, or dropped for the very next; and if what it computed is not known any more.
        """
        if not handle.adopted:
            return False
        expired = isinstance(handle.error, ResultExpired)
        if handle.error is not None and not expired:
            return False
        match handle.status:
            case GoalStatus.CANCELED:
                return True
            case GoalStatus.SUCCEEDED:
                action = self._leaf.action
                return expired and action is not None and not action.holds_base
            case _:
                result = handle.result_message
                return result is not None and error_of(result).endswith(self._id(self._number + 1))

    def _id(self, number: int) -> str:
        return made_goal_id(self._owner, number)


def place_of(node: Behaviour) -> str:
    """Return the place of a node in its tree: from the root, which child of each parent."""
    place = []
    while node.parent is not None:
        place.append(node.parent.children.index(node))
        node = node.parent
    return ".".join(map(str, reversed(place)))
