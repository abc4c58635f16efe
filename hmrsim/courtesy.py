"""Time that stands for a moment after a result, for controllers that know nothing of the clock.

A controller needs some wall time to think of the next goal. At a high factor, simulated time runs on meanwhile, and
the robots are idle for it. So it stands until as many goals have come as results went out, or for so long at most.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.gateway import GoalChanged, Topic
from hmrsim.goal import GoalStatus
from hmrsim.wall import wall_time

if TYPE_CHECKING:
    from hmrsim.gateway import Event


class Courtesy:
    """A sink that counts the results that wait for a next goal.

    Args:
        seconds: Wall seconds that time stands at most, from the last result; 0 for never.
    """

    def __init__(self, seconds: float) -> None:
        self._seconds = seconds
        self._owed = 0
        self._until = 0.0

    def emit(self, event: Event) -> None:
        """Take note of results, and of goals that begin."""
        if not self._seconds or type(event) is not GoalChanged:
            return
        if event.status.terminal:
            self._owed += 1
            self._until = wall_time() + self._seconds
        elif event.status is GoalStatus.ACCEPTED and self._owed:
            self._owed -= 1

    def wants(self, _topic: Topic) -> bool:
        """Return False: what it counts comes unasked."""
        return False

    @property
    def left(self) -> float:
        """Wall seconds for which time stands still; 0 when it may move."""
        if not self._owed:
            return 0.0
        left = self._until - wall_time()
        if left <= 0:
            self._owed = 0
            return 0.0
        return left
