"""How long vehicles wait for the right of way before their goals are aborted."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from simpy import Timeout

    from hmrsim.engine.environment import Environment
    from hmrsim.traffic.policies import Wait


class Patience:
    """Reports waits that last too long; the limit is the same for all, so that one timeout serves them.

    Args:
        env: The simulation's clock and events.
        seconds: The limit; None for no limit.
        waits: Returns whether a wait still goes on.
        lost: Called with a wait that has reached the limit.
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
        """Watch a wait that begins."""
        if self._seconds is None:
            return
        # A robot that is sent the same way again has waited for a while already.
        place = bisect_right(self._patient, wait.since, key=lambda other: other.since)
        self._patient.insert(place, wait)
        if self._ends is None:
            self._wind_up()

    def stop(self) -> None:
        """Forget all waits, and the timeout with them, so that simulated time does not go on for its sake."""
        if self._ends is not None:
            # It may be the event that is processed now.
            if self._ends.callbacks is not None:
                self._env.abandon(self._ends)
            self._ends = None
            self._patient.clear()

    def _wind_up(self) -> None:
        """Set the timeout for the longest wait."""
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
