"""The simulator's liveliness, by its Zenoh token."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING

import zenoh

from hmrsim_zenoh.errors import ClientClosed

if TYPE_CHECKING:
    from hmrsim_zenoh.client.threads import Worker


class Presence:
    """Follows the simulator's token and reports when it has been gone for longer than the grace period.

    The grace period covers router restarts. Nothing is queried or subscribed before `start`.

    Attributes:
        started: Whether the token is followed.
    """

    def __init__(
        self,
        session: zenoh.Session,
        token: str,
        worker: Worker,
        *,
        grace: float,
        on_gone: Callable[[], None],
    ) -> None:
        self._session = session
        self._token = token
        self._worker = worker
        self._grace = grace
        self._on_gone = on_gone
        self._changed = threading.Condition()
        self._starting = threading.Lock()
        self.started = False
        self._subscriber: zenoh.Subscriber[None] | None = None
        self._asked = False
        self._alive = False
        self._seen = False
        self._gone_since = 0.0

    @property
    def seen(self) -> bool:
        """Whether the token has ever been seen."""
        return self._seen

    @property
    def is_there(self) -> bool:
        """Whether the token exists according to the last notification."""
        return self._alive

    @property
    def gone(self) -> bool:
        """Whether the token has been missing for longer than the grace period, counted from `start`."""
        with self._changed:
            return not self._alive and time.monotonic() - self._gone_since >= self._grace

    def start(self) -> None:
        """Begin to follow the token and return at once.

        Raises:
            ClientClosed: The session is closed.
        """
        # Not the callback's lock: Zenoh may be calling it right now.
        with self._starting:
            if self._subscriber is not None:
                return
            self._gone_since = time.monotonic()
            handler = zenoh.handlers.Callback(self._on_sample, lambda: self._set(alive=False), indirect=False)
            try:
                self._subscriber = self._session.liveliness().declare_subscriber(self._token, handler, history=True)
            except zenoh.ZError:
                raise ClientClosed("the client is closed") from None
            self.started = True

    def alive(self, timeout: float) -> bool:
        """Return whether the token is there; the first call queries for at most *timeout* seconds."""
        self.start()
        if not self._asked and not self._alive:
            answered = threading.Event()
            self._ask(answered.set)
            answered.wait(timeout)
            self._asked = True
        return self._alive

    def wait(self, timeout: float) -> bool:
        """Wait for the token, at most *timeout* seconds; return whether it is there."""
        self.start()
        with self._changed:
            return self._changed.wait_for(lambda: self._alive, timeout)

    def close(self) -> None:
        """Stop following the token."""
        with self._starting:
            subscriber, self._subscriber, self.started = self._subscriber, None, False
        if subscriber is not None:
            subscriber.undeclare()

    def _ask(self, then: Callable[[], None]) -> None:
        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda _reply: self._set(alive=True), then, indirect=False
        )
        # A closed session has no liveliness.
        with suppress(zenoh.ZError):
            self._session.liveliness().get(self._token, handler, timeout=self._grace)

    def _on_sample(self, sample: zenoh.Sample) -> None:
        self._set(alive=sample.kind == zenoh.SampleKind.PUT)

    def _set(self, *, alive: bool) -> None:
        with self._changed:
            went = self._alive and not alive
            self._alive = alive
            self._seen = self._seen or alive
            if went:
                self._gone_since = time.monotonic()
            self._changed.notify_all()
        if went:
            self._worker.after(self._grace, self._look_again)

    def _look_again(self) -> None:
        """Query once more before giving up: Zenoh may have reordered the notifications of a token that came back."""
        if not self._alive:
            # In the worker's thread, since Zenoh may end a query with its lock held.
            self._ask(lambda: self._worker.after(0.0, self._conclude))

    def _conclude(self) -> None:
        if not self._alive:
            self._on_gone()
