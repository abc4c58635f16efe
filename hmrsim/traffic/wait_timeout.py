"""For how long robots wait before they give up."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from simpy import Timeout

    from hmrsim.engine.environment import Environment
    from hmrsim.traffic.admission import Wait


class Patience:
    """Tells of those that have waited for too long; all have the same patience, so that one clock will do.

    Args:
        env: The simulation's clock and events.
        seconds: For how long; None for ever.
        waits: Returns whether a robot still waits for what it waited for.
        lost: Called when one has no patience any more.
    """

    def __init__(
        self,
        env: Environment,
        seconds: float | None,
        *,
        waits: Callable[[Wait], bool],
        lost: Callable[[Wait], None],
    ) -> None:
        self._env = env
        self._seconds = seconds
        self._waits = waits
        self._lost = lost
        self._patient: deque[Wait] = deque()
        self._ends: Timeout | None = None

    def begin(self, wait: Wait) -> None:
        """Begin to count for a robot that begins to wait."""
        if self._seconds is None:
            return
        # Some have waited for a while already.
        place = bisect_right(self._patient, wait.since, key=lambda other: other.since)
        self._patient.insert(place, wait)
        if self._ends is None:
            self._wind_up()

    def stop(self) -> None:
        """Count for nobody: nobody waits, and time need not go on for the clock's sake."""
        if self._ends is not None:
            # It may be what happens just now.
            if self._ends.callbacks is not None:
                self._env.abandon(self._ends)
            self._ends = None
            self._patient.clear()

    def _wind_up(self) -> None:
        """Set the clock for the one that has waited longest."""
        self._ends = None
        while self._patient and not self._waits(self._patient[0]):
            self._patient.popleft()
        if self._patient and self._seconds is not None:
            left = self._patient[0].since + self._seconds - self._env.now
            self._ends = self._env.timeout(max(0.0, left))
            self._ends.callbacks = [lambda _event: self._end()]

    def _end(self) -> None:
        wait = self._patient.popleft()
        if self._waits(wait):
            self._lost(wait)
        self._wind_up()
