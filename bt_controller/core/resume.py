"""Going on where a controller was when it ended: each goal has the same id in each of its lives.

A restarted controller walks its tree from the beginning. What was done, or is under way, the simulator knows by its
id already: the leaf takes it over instead of doing it again.

A step is what a leaf does from when it begins to its end, and is known by mission, place in the tree, and the goal
with which it begins. Another goal at the same place is another step, of which nothing was done: also where the goal
depends on where the robot is, as a path that is computed anew does. The step's goals, as it replaces them or sends
them again, and those of the same step in a loop, are counted.
"""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import error_of
from hmrsim.protocol.goal import GoalStatus, made_goal_id
from hmrsim_zenoh.errors import ResultExpired

if TYPE_CHECKING:
    from py_trees.behaviour import Behaviour

    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.goal_handle import GoalHandle

_PREEMPTED: Final = "preempted by goal "


class Resumption:
    """The ids of a leaf's goals.

    Args:
        owner: Whose goals they are: participant, mission, robot and place in the tree.
        robot: Whose action.
        action: What they are goals of.

    Attributes:
        repeats: Whether what has ended in an earlier life is done again.
    """

    def __init__(self, owner: str, robot: str, action: AnyAction) -> None:
        self.repeats = False
        self._owner = f"{owner}/{robot}/{action.name}"
        self._computes = not action.holds_base
        self._step = ""
        self._begun: Counter[str] = Counter()
        self._latest: tuple[str, GoalHandle[Any, Any]] | None = None

    def begin(self, goal: Message) -> None:
        """Begin the step that begins with a goal."""
        self._step = f"{self._owner}/{_digest(goal)}"

    def next_id(self) -> str:
        """Return the id of the step's next goal.

        One that was rejected, or of which nobody heard, was never begun as far as we know: the next has its id. So
        the ids of those that were begun have no gaps, and the next life finds them one after the other.
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
        """Return whether a goal of an earlier life has ended so that the next one of the step tells more.

        That is if it was canceled by then, or dropped for another goal, as by what this life did first; and if what
        it computed is not known any more. What happens to it later is meant for us, unless it is the step's next
        goal.
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


def _digest(goal: Message) -> str:
    """Return what is the same for equal goals; when they were made does not count."""
    wanted = _without_stamps(json.loads(goal.model_dump_json()))
    return hashlib.blake2b(json.dumps(wanted, sort_keys=True).encode(), digest_size=16).hexdigest()


def _without_stamps(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_stamps(item) for key, item in value.items() if key != "stamp"}
    return [_without_stamps(item) for item in value] if isinstance(value, list) else value
