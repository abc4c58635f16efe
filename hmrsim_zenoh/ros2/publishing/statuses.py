"""The status lists of one action of one robot, in ROS's bytes."""

from __future__ import annotations

from itertools import compress, count
from operator import is_not
from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.builtin_interfaces import values_of

if TYPE_CHECKING:
    from collections.abc import Sequence

    from hmrsim.protocol.answers import GoalEntry
    from hmrsim_zenoh.ros2.codec.types import MessageType

_SECOND: Final = 33
"""Where the second entry of a list begins. From it on all are alike; the first lacks their padding."""
_PADDING: Final = slice(16, 19)
"""After the goal's id: the times that follow are aligned to 4 bytes, and an entry has 25."""


class Statuses:
    """Makes status lists; what an entry was made into is kept, as most of a long list stays as it was.

    Args:
        type_: The type of status lists.
    """

    def __init__(self, type_: MessageType) -> None:
        self._type = type_
        self._goals: list[GoalEntry] = []
        self._made: list[bytes] = []

    def encode(self, goals: Sequence[GoalEntry]) -> bytes:
        """Return the list of these goals."""
        self._drop_oldest(goals)
        # Looking at each would take most of the time: that nearly all are the same is seen without Python's help.
        for i in compress(count(), map(is_not, goals, self._goals)):
            if self._goals[i] != goals[i]:
                self._made[i] = self._entry(goals[i])
        self._made[len(self._goals) :] = [self._entry(goal) for goal in goals[len(self._goals) :]]
        del self._made[len(goals) :]
        self._goals = list(goals)
        made = self._made
        first = made[0][: _PADDING.start] + made[0][_PADDING.stop :] if made else b""
        return b"\0\1\0\0%b%b%b" % (len(made).to_bytes(4, "little"), first, b"".join(made[1:]))

    def _drop_oldest(self, goals: Sequence[GoalEntry]) -> None:
        """Drop those at the beginning that are not there any more, so that the others keep their places."""
        oldest = goals[0].goal_id if goals else ""
        gone = next((i for i, goal in enumerate(self._goals) if goal.goal_id == oldest), len(self._goals))
        del self._goals[:gone], self._made[:gone]

    def _entry(self, goal: GoalEntry) -> bytes:
        info = {"goal_id": {"uuid": bytes.fromhex(goal.goal_id)}, "stamp": values_of(goal.stamp)}
        return self._type.encode({"status_list": [{"goal_info": info, "status": int(goal.status)}] * 2})[_SECOND:]
