"""The rate limit of published feedback."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import FeedbackSent

MIN_WALL_SECONDS: Final = 1 / 20
"""Wall seconds between two feedback messages of one goal: at most 20 a second."""


class FeedbackLimiter:
    """Limits the rate of each goal's feedback; a goal's last feedback always passes.

    Attributes:
        sent: When feedback of each goal was last published, until the goal is forgotten.
    """

    def __init__(self) -> None:
        self.sent: dict[str, float] = {}

    def passes(self, event: FeedbackSent) -> bool:
        """Return whether to publish feedback; if so, it counts as published."""
        now = time.monotonic()
        if not event.last and now - self.sent.get(event.goal_id, -1.0) < MIN_WALL_SECONDS:
            return False
        self.sent[event.goal_id] = now
        return True

    def forget(self, goal_id: str) -> None:
        """Forget a goal that has ended."""
        self.sent.pop(goal_id, None)
