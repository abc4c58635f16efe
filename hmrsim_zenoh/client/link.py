"""The link that all goals of a client share: connection, worker thread, and the simulator's presence."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from typing import TYPE_CHECKING

from hmrsim.protocol.goal import made_goal_id
from hmrsim_zenoh.client.connection import Connection
from hmrsim_zenoh.client.subscription import SimClock, Subscription
from hmrsim_zenoh.client.zenoh_connection import ZenohConnection
from hmrsim_zenoh.errors import ClientClosed, SimulatorGone, SimulatorNotFound

if TYPE_CHECKING:
    import zenoh

    from hmrsim.errors import HmrsimError
    from hmrsim_zenoh.wire.enclave import Enclave
    from hmrsim_zenoh.wire.keys import Keys


class Link:
    """A connection with its worker thread and the simulator's liveliness.

    A simulator that has been away for longer than the grace period is gone: that covers restarts of routers.
    Nothing is queried or subscribed before `follow`.

    Attributes:
        keys: How the simulator's keys are spelled.
        connection: Takes commands.
        worker: Runs deferred calls.
        present: Whether the simulator is there, according to the last notification.
        acknowledge_timeout: Wall seconds within which a goal has to be accepted or rejected.
    """

    def __init__(
        self,
        session: zenoh.Session | Connection,
        keys: Keys,
        *,
        acknowledge_timeout: float,
        grace: float,
        enclave: Enclave | None = None,
    ) -> None:
        self.keys = keys
        self.connection: Connection = (
            session if isinstance(session, Connection) else ZenohConnection(session, keys, enclave)
        )
        self.worker = self.connection.worker()
        self.present = False
        self.acknowledge_timeout = acknowledge_timeout
        self._grace = grace
        self._lock = threading.Lock()
        # The functions that fail the active goals and the participation in lockstep, in the order in which these began.
        self._active: dict[Callable[[Exception], None], None] = {}
        self._owner = self.connection.token()
        self._sent = 0
        self._subscriptions: list[Subscription] = []
        self._closed = False
        self._changed = threading.Condition()
        self._starting = threading.Lock()
        self._unfollow: Callable[[], object] | None = None
        self._asked = False
        self._seen = False
        # When the simulator went, or when it began to be followed.
        self._gone_since = 0.0

    @property
    def closed(self) -> bool:
        """Return whether the link or its session is known to be closed."""
        return self._closed or self.connection.broken

    def check_open(self) -> None:
        """Check that the link is open.

        Raises:
            ClientClosed: It is not.
        """
        if self._closed or self.connection.broken:
            raise ClientClosed("the client is closed")

    def enter(self, fail: Callable[[Exception], None]) -> None:
        """Call a function with the error when the simulator goes or the link is closed, until `leave`.

        Raises:
            ClientClosed: The link is closed already.
        """
        if self._unfollow is None:
            self.check_open()
            self.follow()
        with self._lock:
            # Closing fails only what has entered by then.
            self.check_open()
            self._active[fail] = None

    def leave(self, fail: Callable[[Exception], None]) -> None:
        """Remove a function of `enter`."""
        with self._lock:
            self._active.pop(fail, None)

    def alarm(self, seconds: float, ring: Callable[[], None]) -> SimClock:
        """Call a function once so many simulated seconds have passed, until the clock is closed.

        Raises:
            ClientClosed: The link is closed.
        """
        end = math.inf

        def on_time(now: float) -> None:
            nonlocal end
            end = now + seconds if end == math.inf else end
            if now >= end:
                ring()

        return SimClock(self, on_time)

    def subscribe(self, key: str, callback: Callable[[str, bytes], None], *, history: bool = False) -> Subscription:
        """Call back with the key and payload of each sample, in a separate thread, until it or the link is closed.

        Raises:
            ClientClosed: The link is closed.
        """
        self.check_open()
        subscription = Subscription(self.connection, key, callback, history=history)
        with self._lock:
            self._subscriptions = [*(each for each in self._subscriptions if not each.closed), subscription]
        return subscription

    def next_goal_id(self) -> str:
        """Return a goal id that is unique across all clients."""
        with self._lock:
            self._sent += 1
            return made_goal_id(self._owner, self._sent)

    def follow(self) -> None:
        """Begin to follow the simulator's presence and return at once.

        Raises:
            ClientClosed: The session is closed.
        """
        # Not the callback's lock: Zenoh may be calling it right now.
        with self._starting:
            if self._unfollow is None:
                self._gone_since = time.monotonic()
                self._unfollow = self.connection.follow(self._set)

    def alive(self, timeout: float) -> bool:
        """Return whether the simulator is there; the first call queries for at most *timeout* seconds."""
        self.follow()
        if not self._asked and not self.present:
            answered = threading.Event()
            self._ask(answered.set)
            answered.wait(timeout)
            self._asked = True
        return self.present

    def wait(self, timeout: float) -> bool:
        """Wait for the simulator, at most *timeout* seconds; return whether it is there."""
        self.follow()
        with self._changed:
            return self._changed.wait_for(lambda: self.present, timeout)

    def absence(self) -> HmrsimError | None:
        """Return why no answer can come; None while the simulator is alive or may still come back."""
        if self.closed:
            return ClientClosed("the client was closed")
        with self._changed:
            if self.present or time.monotonic() - self._gone_since < self._grace:
                return None
        if self._seen:
            return SimulatorGone(
                f"the simulator {self.keys.prefix!r} is gone: its token {self.keys.alive()!r} has disappeared; "
                "start it again, or look in its output for why it has ended"
            )
        return SimulatorNotFound(f"no simulator answers: {self.unseen}")

    @property
    def unseen(self) -> str:
        """A possible reason why no simulator was found, and a remedy."""
        token, enclave = self.keys.alive(), self.connection.enclave
        if enclave is None:
            return f"there is no token {token!r}; start `hmrsim run WORLD`, or check --connect and --prefix"
        return (
            f"there is no token {token!r}, or it is hidden from {enclave.name!r}, who may be revoked; "
            "ask `hmrsim security explain`, or check --prefix"
        )

    def close(self) -> None:
        """Fail all active goals and close the subscriptions; the session stays open."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            subscriptions = list(self._subscriptions)
        self.fail(ClientClosed("the client was closed while the goal was under way"))
        self.connection.unlisten()
        for subscription in subscriptions:
            subscription.close()
        with self._starting:
            unfollow, self._unfollow = self._unfollow, None
        if unfollow is not None:
            unfollow()
        self.worker.close()

    def fail(self, error: Exception) -> None:
        """Fail all active goals and the participation in lockstep."""
        with self._lock:
            active = list(self._active)
        for fail in active:
            fail(error)

    def _ask(self, then: Callable[[], None]) -> None:
        self.connection.look(lambda: self._set(True), then, timeout=self._grace)

    def _set(self, present: bool) -> None:  # noqa: FBT001 - a callback
        with self._changed:
            went = self.present and not present
            self.present = present
            self._seen = self._seen or present
            if went:
                self._gone_since = time.monotonic()
            self._changed.notify_all()
        if went:
            self.worker.after(self._grace, self._look_again)

    def _look_again(self) -> None:
        """Query once more before giving up: Zenoh may have reordered the notifications of a token that came back."""
        if not self.present:
            # In the worker's thread, since Zenoh may end a query with its lock held.
            self._ask(lambda: self.worker.after(0.0, self._give_up))

    def _give_up(self) -> None:
        if not self.present and (error := self.absence()):
            self.fail(error)
