"""A subscription that passes samples to a callback in its own thread."""

from __future__ import annotations

import logging
import threading
from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final, Protocol, Self

import zenoh
import zenoh.ext

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim_zenoh.loopback.session import LoopbackSession
from hmrsim_zenoh.wire.envelopes import UnreadableError, plain, read

if TYPE_CHECKING:
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)

_MAX_WAITING: Final = 10_000


class Subscription:
    """Calls back for each sample until closed.

    The callback may block: the latest 10,000 samples wait meanwhile. A callback that blocked Zenoh's own thread
    would hold up the simulator. Within one process, the thread that advances time calls the callback.
    """

    def __init__(
        self, session: zenoh.Session, key: str, callback: Callable[[str, bytes], None], *, history: bool
    ) -> None:
        self._key = key
        self._callback = callback
        self._changed = threading.Condition()
        self._waiting: deque[tuple[str, bytes]] = deque(maxlen=_MAX_WAITING)
        self._closed = False
        self._calling = False
        self._thread: threading.Thread | None = None
        if isinstance(session, LoopbackSession):
            for reply in session.get(key) if history else ():
                self._on_local_sample(reply.ok)
            self._subscriber: Any = session.declare_subscriber(key, self._on_local_sample)
            return
        self._subscriber = self._declared(session, history=history)
        # Not in Zenoh's receive loop: a daemon thread that the interpreter ends there crashes the process.
        self._thread = threading.Thread(target=self._run, name=f"subscription to {key}", daemon=True)
        self._thread.start()

    @property
    def closed(self) -> bool:
        """Return whether the subscription is closed."""
        return self._closed

    def close(self) -> None:
        """Stop calling back; waits for a running callback, unless it is the one that closes."""
        with self._changed:
            if self._closed:
                return
            self._closed = True
            self._changed.notify_all()
        self._subscriber.undeclare()
        if self._thread is not None and self._thread is not threading.current_thread():
            self._thread.join()

    def settle(self) -> None:
        """Wait until the callback was called with all samples that have come."""
        if self._thread is not None:
            with self._changed:
                self._changed.wait_for(lambda: self._closed or not (self._waiting or self._calling))

    def __enter__(self) -> Self:
        """Return the subscription."""
        return self

    def __exit__(self, *_error: object) -> None:
        """Close it."""
        self.close()

    def _declared(self, session: zenoh.Session, *, history: bool) -> Any:  # plain and advanced subscriber
        handler = zenoh.handlers.Callback(self._on_sample, indirect=False)
        if not history:
            return session.declare_subscriber(self._key, handler)
        return zenoh.ext.declare_advanced_subscriber(
            session, self._key, handler, history=zenoh.ext.HistoryConfig(detect_late_publishers=True)
        )

    def _on_sample(self, sample: zenoh.Sample) -> None:
        item = str(sample.key_expr), sample.payload.to_bytes()
        with self._changed:
            self._waiting.append(item)
            self._changed.notify_all()

    def _on_local_sample(self, sample: Any) -> None:
        if sample is not None and not self._closed:
            self._call(str(sample.key_expr), sample.payload.to_bytes())

    def _run(self) -> None:
        while (item := self._next()) is not None:
            self._call(*item)

    def _call(self, key: str, payload: bytes) -> None:
        try:
            self._callback(key, payload)
        except Exception:  # noqa: BLE001 - an error in one callback must not stop the others
            _log.exception("the callback of the subscription to %r failed", self._key)

    def _next(self) -> tuple[str, bytes] | None:
        with self._changed:
            self._calling = False
            self._changed.notify_all()
            self._changed.wait_for(lambda: self._waiting or self._closed)
            self._calling = not self._closed
            return None if self._closed else self._waiting.popleft()


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
        """Close the subscription to the clock."""
        self._subscription.close()

    def _on_sample(self, key: str, payload: bytes) -> None:
        try:
            self._now = now = read_clock(payload)
        except UnreadableError as error:
            _log.warning("%s: unreadable: %s", key, error)
            return
        self._on_time(now)
