"""The simulated time, as the simulator publishes it."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Protocol

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim_zenoh.wire.envelopes import UnreadableError, plain, read

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim_zenoh.client.subscription import Subscription
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)


def read_clock(payload: bytes) -> float:
    """Return the simulated seconds of a ``Clock``.

    Raises:
        UnreadableError: It is none.
    """
    message: Clock = read(plain(Clock), payload)
    return message.clock.to_nanoseconds() / NANOSECONDS


class Subscriber(Protocol):
    """What a clock knows of a `Client`."""

    keys: Keys

    def subscribe(self, key: str, callback: Callable[[str, bytes], None], *, history: bool = False) -> Subscription:
        """Call back with key and payload of each sample."""


class SimClock:
    """Follows ``_world/clock``.

    Args:
        client: Where the clock is heard.
        on_time: Called with each time that is heard, in the subscription's thread.
    """

    def __init__(self, client: Subscriber, on_time: Callable[[float], None]) -> None:
        self._on_time = on_time
        self._now: float | None = None
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
            self._now = now = read_clock(payload)
        except UnreadableError as error:
            _log.warning("%s: unreadable: %s", key, error)
            return
        self._on_time(now)
