"""Resuming a mission after the controller restarts: each goal has the same id in every run.

A restarted controller ticks its tree from the beginning. The simulator knows finished and active goals by their ids:
the leaf adopts such a goal instead of sending a new one.

A step is one execution of a leaf. It is identified by the mission, the place in the tree, and the leaf's first goal.
Another goal at the same place is another step, which is not done yet, even if the goal differs only since it depends on
the robot's pose, as a computed path does. The goals of a step that replace each other or are sent again, and those of
the same step in a loop, are numbered.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from typing import TYPE_CHECKING, Any, Final

from pydantic_core import to_json

from hmrsim.actions import error_of
from hmrsim.protocol.goal import GoalStatus, made_goal_id
from hmrsim_zenoh.errors import ResultExpired

if TYPE_CHECKING:
    from collections.abc import Mapping

    from py_trees.behaviour import Behaviour

    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.goal_handle import GoalHandle

_PREEMPTED: Final = "preempted by goal "


class Resumption:
    """Generates the ids of a leaf's goals.

    Args:
        owner: The owner of the goals: participant, mission, robot and place in the tree.

    Attributes:
        repeats: Whether goals that ended in an earlier run are repeated.
    """

    def __init__(self, owner: str, robot: str, action: AnyAction) -> None:
        self.repeats = False
        self._owner = f"{owner}/{robot}/{action.name}"
        self._computes = not action.holds_base
        self._step = ""
        self._begun: Counter[str] = Counter()
        self._latest: tuple[str, GoalHandle[Any, Any]] | None = None

    def begin(self, goal: Message | Mapping[str, Any]) -> None:
        """Begin the step whose first goal this is."""
        self._step = f"{self._owner}/{_digest(goal)}"

    def next_id(self) -> str:
        """Return the id of the step's next goal.

        A goal that was rejected or never arrived did not begin: the next goal has its id. So the ids of the goals that
        began have no gaps, and the next run finds them one after the other.
        """
        if self._latest is not None:
            step, latest = self._latest
            if latest.error is not None and not isinstance(latest.error, ResultExpired):
                self._begun[step] -= 1
                self._latest = None
        return made_goal_id(self._step, self._begun[self._step] + 1)

    def note(self, handle: GoalHandle[Any, Any]) -> None:
        """Count the goal that was sent with that id."""
        self._begun[self._step] += 1
        self._latest = self._step, handle

    def is_undone(self, handle: GoalHandle[Any, Any]) -> bool:
        """Return whether a goal of an earlier run has ended so that the step's next goal counts instead.

        That holds if the goal was canceled or preempted by then, for instance by the first goals of this run, and if
        its result has expired. A later end counts for this run, unless the step's next goal caused it.
        """
        if handle.found is None:
            return False
        expired = isinstance(handle.error, ResultExpired)
        if handle.error is not None and not expired:
            return False
        if self.repeats and handle.found.terminal:
            return True
        match handle.status:
            case GoalStatus.CANCELED:
                return handle.found in (GoalStatus.CANCELING, GoalStatus.CANCELED)
            case GoalStatus.SUCCEEDED:
                return expired and self._computes
            case _:
                # No code of Nav2's says that a goal was preempted, but the simulator's text says by which.
                why = "" if handle.result_message is None else error_of(handle.result_message)
                return self.next_id() in why or (handle.found.terminal and why.startswith(_PREEMPTED))


def place_of(node: Behaviour) -> str:
    """Return the place of a node in its tree: from the root, which child of each parent."""
    place = []
    while node.parent is not None:
        place.append(node.parent.children.index(node))
        node = node.parent
    return ".".join(map(str, reversed(place)))


def _digest(goal: Message | Mapping[str, Any]) -> str:
    """Return a key that is the same for equal goals, whatever their stamps."""
    wanted = _without_stamps(json.loads(to_json(goal)))
    return hashlib.blake2b(json.dumps(wanted, sort_keys=True).encode(), digest_size=16).hexdigest()


def _without_stamps(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_stamps(item) for key, item in value.items() if key != "stamp"}
    return [_without_stamps(item) for item in value] if isinstance(value, list) else value
