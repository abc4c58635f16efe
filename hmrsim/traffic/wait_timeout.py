"""How long vehicles wait for the right of way before their goals are aborted."""

from __future__ import annotations

from bisect import bisect_right
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simpy import Timeout

    from hmrsim.engine.environment import Environment
    from hmrsim.traffic.policies import Wait


class WaitTimeout:
    """Reports waits that last too long; the limit is the same for all, so that one timeout serves them.

    Args:
        seconds: The limit; None for no limit.
        waits: Returns whether a wait still goes on.
        expired: Called with a wait that has reached the limit.
    """

    def __init__(
        self,
        env: Environment,
        seconds: float | None,
        *,
        waits: Callable[[Wait], bool],
        expired: Callable[[Wait], None],
    ) -> None:
        self._env = env
        self._seconds = seconds
        self._waits = waits
        self._expired = expired
        self._waiting: deque[Wait] = deque()
        self._timeout: Timeout | None = None

    def begin(self, wait: Wait) -> None:
        """Watch a wait that begins."""
        if self._seconds is None:
            return
        # A robot that is sent the same way again has waited for a while already.
        place = bisect_right(self._waiting, wait.since, key=lambda other: other.since)
        self._waiting.insert(place, wait)
        if self._timeout is None:
            self._set_timeout()

    def stop(self) -> None:
        """Forget all waits, and the timeout with them, so that simulated time does not go on for its sake."""
        if self._timeout is not None:
            # It may be the event that is processed now.
            if self._timeout.callbacks is not None:
                self._env.abandon(self._timeout)
            self._timeout = None
            self._waiting.clear()

    def _set_timeout(self) -> None:
        """Set the timeout for the longest wait."""
        self._timeout = None
        while self._waiting and not self._waits(self._waiting[0]):
            self._waiting.popleft()
        if self._waiting and self._seconds is not None:
            left = self._waiting[0].since + self._seconds - self._env.now
            self._timeout = self._env.timeout(max(0.0, left))
            self._timeout.callbacks = [lambda _event: self._expire()]

    def _expire(self) -> None:
        wait = self._waiting.popleft()
        if self._waits(wait):
            self._expired(wait)
        self._set_timeout()
