"""The timeout after which goals of vehicles that wait for the right of way are aborted."""

from __future__ import annotations

import heapq
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from simpy import Timeout

    from hmrsim.engine.environment import Environment
    from hmrsim.traffic.rules import Wait


class WaitTimeout:
    """Reports waits that have been hopeless for too long; the limit is the same for all, so one timeout serves them.

    Args:
        seconds: The limit; None for no limit.
        since: Returns since when neither the vehicle of a wait nor any of those for which it waits has made progress,
            in simulated seconds. Infinite if one of them does now; None if the wait is over.
        expired: Called with a wait that has reached the limit.
    """

    def __init__(
        self,
        env: Environment,
        seconds: float | None,
        *,
        since: Callable[[Wait], float | None],
        expired: Callable[[Wait], None],
    ) -> None:
        self._env = env
        self._seconds = seconds
        self._since = since
        self._expired = expired
        self._number = 0
        self._waiting: list[tuple[float, int, Wait]] = []
        self._timeout: Timeout | None = None

    def begin(self, wait: Wait) -> None:
        """Watch a wait that begins."""
        if self._seconds is None:
            return
        self._add(wait.since, wait)
        if self._timeout is not None and self._waiting[0][2] is wait and self._timeout.callbacks is not None:
            self._env.abandon(self._timeout)
            self._timeout = None
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

    def _add(self, since: float, wait: Wait) -> None:
        self._number += 1
        heapq.heappush(self._waiting, (since, self._number, wait))

    def _set_timeout(self) -> None:
        """Set the timeout for the wait that may reach the limit next."""
        self._timeout = None
        while self._waiting and self._since(self._waiting[0][2]) is None:
            heapq.heappop(self._waiting)
        if self._waiting and self._seconds is not None:
            left = self._waiting[0][0] + self._seconds - self._env.now
            self._timeout = self._env.timeout(max(0.0, left))
            self._timeout.callbacks = [lambda _event: self._expire()]

    def _expire(self) -> None:
        looked, _, wait = heapq.heappop(self._waiting)
        since = self._since(wait)
        if since is not None:
            if since <= looked:
                self._expired(wait)
            else:
                # They have made progress meanwhile: the patience begins anew when the last of them stops.
                self._add(min(since, self._env.now), wait)
        self._set_timeout()
