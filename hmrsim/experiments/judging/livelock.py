"""A controller that goes on within one instant: it sends goals that fail at once, so that time never passes."""

from __future__ import annotations

from typing import Final

_MANY: Final = 1000
"""How many goals of a robot's action may fail within one instant."""


class Livelock:
    """Counts the goals of each robot's action that fail within one instant."""

    def __init__(self) -> None:
        self._now = -1
        self._counts: dict[tuple[str, str], int] = {}

    def failed(self, stamp: int, robot: str, action: str, why: str) -> str:
        """Count a goal that is aborted or rejected; return what is wrong, in words, if it is one too many.

        Args:
            stamp: When, in simulated nanoseconds.
            robot: Whose.
            action: Of which action.
            why: What its result says, or the rejection.
        """
        if stamp != self._now:
            self._now, self._counts = stamp, {}
        count = self._counts[robot, action] = self._counts.get((robot, action), 0) + 1
        if count < _MANY:
            return ""
        last = f"; the last one: {why}" if why else ""
        return f"time stands still: {count:,} goals of {robot}/{action} failed within one instant{last}"
