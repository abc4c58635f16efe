"""How much feedback of a goal is published: no more than somebody can look at."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import FeedbackSent

MIN_WALL_SECONDS: Final = 1 / 20
"""Between two feedback messages of one goal: there are never more than 20 a wall second."""


class Thinning:
    """Lets through what is not too soon after the last of the same goal, and always a goal's last."""

    def __init__(self) -> None:
        self._sent: dict[str, float] = {}

    def passes(self, event: FeedbackSent) -> bool:
        """Return whether feedback is to be published; it counts as published then."""
        now = time.monotonic()
        if not event.last and now - self._sent.get(event.goal_id, -1.0) < MIN_WALL_SECONDS:
            return False
        self._sent[event.goal_id] = now
        return True

    def forget(self, goal_id: str) -> None:
        """Drop what is known of a goal, as it has ended."""
        self._sent.pop(goal_id, None)
