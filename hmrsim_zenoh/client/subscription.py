"""A subscription that passes samples to a callback in its own thread."""

from __future__ import annotations

import logging
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Final, Protocol, Self

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim_zenoh.client.worker import Worker
from hmrsim_zenoh.errors import ClientClosed
from hmrsim_zenoh.wire.envelopes import UnreadableError, plain, read

if TYPE_CHECKING:
    from hmrsim_zenoh.client.connection import Connection
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)

_MAX_WAITING: Final = 10_000


class Subscription:
    """Calls back for each sample until closed.

    The callback may block: the latest 10,000 samples wait meanwhile. A callback that blocked Zenoh's own thread
    would hold up the simulator. Within one process, the thread that advances time calls the callback.

    Attributes:
        closed: Whether it is closed.
    """

    def __init__(
        self, connection: Connection, key: str, callback: Callable[[str, bytes], None], *, history: bool
    ) -> None:
        self._key = key
        self._callback = callback
        self.closed = False
        # Not in Zenoh's receive loop: a daemon thread that the interpreter ends there crashes the process.
        self._worker = None if connection.in_process else Worker(f"subscription to {key}", most=_MAX_WAITING)
        try:
            self._undeclare = connection.subscribe(key, self._take, history=history)
        except ClientClosed:
            if self._worker is not None:
                self._worker.close()
            raise

    def close(self) -> None:
        """Stop calling back; waits for a running callback, unless it is the one that closes."""
        if not self.closed:
            self.closed = True
            self._undeclare()
            if self._worker is not None:
                self._worker.close()

    def settle(self) -> None:
        """Wait until the callback was called with all samples that have come."""
        if self._worker is not None:
            self._worker.settle()

    def __enter__(self) -> Self:
        """Return the subscription."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Close it."""
        self.close()

    def _take(self, key: str, payload: bytes) -> None:
        if self._worker is None:
            self._call(key, payload)
        else:
            self._worker.after(0.0, partial(self._call, key, payload))

    def _call(self, key: str, payload: bytes) -> None:
        try:
            if not self.closed:
                self._callback(key, payload)
        except Exception:  # noqa: BLE001 - an error in one callback must not stop the others
            _log.exception("the callback of the subscription to %r failed", self._key)


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
    """Follows simulated time by ``_world/clock``.

    Args:
        on_time: Called with each time received, in the subscription's thread.

    Attributes:
        now: Simulated seconds; None until a message was received.
    """

    def __init__(self, client: Subscriber, on_time: Callable[[float], None]) -> None:
        self._on_time = on_time
        self.now: float | None = None
        self._subscription = client.subscribe(client.keys.world("clock"), self._on_sample, history=True)

    def close(self) -> None:
        """Close the subscription to the clock."""
        self._subscription.close()

    def _on_sample(self, key: str, payload: bytes) -> None:
        try:
            self.now = now = read_clock(payload)
        except UnreadableError as error:
            _log.warning("%s: unreadable: %s", key, error)
            return
        self._on_time(now)
