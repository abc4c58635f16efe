"""The simulated time that the simulator publishes."""

from __future__ import annotations

import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim_zenoh.wire.envelopes import UnreadableError, plain, read

if TYPE_CHECKING:
    from hmrsim_zenoh.client.subscription import Subscription
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)


def read_clock(payload: bytes) -> float:
    """Return the simulated seconds of a ``Clock``.

    Raises:
        UnreadableError: The payload is not a ``Clock``.
    """
    message: Clock = read(plain(Clock), payload)
    return message.clock.to_nanoseconds() / NANOSECONDS


class Subscriber(Protocol):
    """The part of a `Client` that a clock uses."""

    keys: Keys

    def subscribe(self, key: str, callback: Callable[[str, bytes], None], *, history: bool = False) -> Subscription:
        """Call back with the key and payload of each sample."""


class SimClock:
    """Subscribes to ``_world/clock``.

    Args:
        on_time: Called with each time received, in the subscription's thread.
    """

    def __init__(self, client: Subscriber, on_time: Callable[[float], None]) -> None:
        self._on_time = on_time
        self._now: float | None = None
        self._subscription = client.subscribe(client.keys.world("clock"), self._on_sample, history=True)

    @property
    def now(self) -> float | None:
        """Simulated seconds; None until a message was received."""
        return self._now

    def close(self) -> None:
        """Unsubscribe."""
        self._subscription.close()

    def _on_sample(self, key: str, payload: bytes) -> None:
        try:
            self._now = now = read_clock(payload)
        except UnreadableError as error:
            _log.warning("%s: unreadable: %s", key, error)
            return
        self._on_time(now)
