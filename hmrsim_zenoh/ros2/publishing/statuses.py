"""The status lists of one action of one robot, in ROS's bytes."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import compress, count
from operator import is_not
from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.builtin_interfaces import values_of

if TYPE_CHECKING:
    from hmrsim.protocol.answers import GoalEntry
    from hmrsim_zenoh.ros2.codec.types import MessageType

_SECOND: Final = 33
"""Where the second entry of a list begins. All entries except the first have the same padding."""
_PADDING: Final = slice(16, 19)
"""After the goal's id: the times that follow are aligned to 4 bytes, and an entry has 25."""


class Statuses:
    """Encodes status lists; encoded entries are cached, as most of a long list does not change."""

    def __init__(self, type_: MessageType) -> None:
        self._type = type_
        self._goals: list[GoalEntry] = []
        self._made: list[bytes] = []

    def encode(self, goals: Sequence[GoalEntry]) -> bytes:
        """Return the list of these goals."""
        self._drop_oldest(goals)
        # A Python loop over all entries would take most of the time: identical ones are skipped in C.
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
        """Drop expired entries at the beginning, so that the others keep their indices."""
        oldest = goals[0].goal_id if goals else ""
        gone = next((i for i, goal in enumerate(self._goals) if goal.goal_id == oldest), len(self._goals))
        del self._goals[:gone], self._made[:gone]

    def _entry(self, goal: GoalEntry) -> bytes:
        info = {"goal_id": {"uuid": bytes.fromhex(goal.goal_id)}, "stamp": values_of(goal.stamp)}
        return self._type.encode({"status_list": [{"goal_info": info, "status": int(goal.status)}] * 2})[_SECOND:]
