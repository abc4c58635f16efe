"""The simulated time, as the simulator publishes it."""

from __future__ import annotations

import logging
import threading
from typing import TYPE_CHECKING

from pydantic import ValidationError

from hmrsim.interfaces.rosgraph_msgs import Clock

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim_zenoh.client import Client

_log = logging.getLogger(__name__)


class SimClock:
    """Follows ``_world/clock``, and calls back each period of simulated time.

    The periods count from the first time that is heard of, and anew when time goes back, as after a reset.

    Args:
        client: Where the clock is heard.
        period: Simulated seconds.
        on_period: Called in the subscription's thread; once, however many periods went by.
    """

    def __init__(self, client: Client, period: float, on_period: Callable[[], None]) -> None:
        self._period = period
        self._on_period = on_period
        self._lock = threading.Lock()
        self._now: float | None = None
        self._due = 0.0
        self._subscription = client.subscribe(client.keys.world("clock"), self._on_sample, history=True)

    @property
    def now(self) -> float | None:
        """Simulated seconds; None until the clock was heard."""
        return self._now

    def close(self) -> None:
        """Follow the clock no longer."""
        self._subscription.close()

    def _on_sample(self, key: str, payload: bytes) -> None:
        try:
            now = Clock.model_validate_json(payload).clock.to_nanoseconds() / 1e9
        except ValidationError as error:
            _log.warning("%s: unreadable: %s", key, error)
            return
        if self._take(now):
            self._on_period()

    def _take(self, now: float) -> bool:
        """Set the time; return whether a period is over."""
        with self._lock:
            before, self._now = self._now, now
            if before is None or now < before:
                self._due = now + self._period
                return False
            if now < self._due:
                return False
            self._due += self._period * ((now - self._due) // self._period + 1)
            return True
