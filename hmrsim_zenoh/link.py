"""What all goals of a client share: its session, and requests that end in exactly one way."""

from __future__ import annotations

import threading
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import zenoh

from hmrsim_zenoh.errors import ClientClosed, NobodyThere, RequestError, SimulatorGone
from hmrsim_zenoh.presence import Presence
from hmrsim_zenoh.worker import Worker

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.errors import HmrsimError
    from hmrsim_zenoh.keys import Keys

Answer = bytes | RequestError | None
"""The reply; or the error that was replied; or None: nothing came back, and what became of it is not known."""

# Zenoh's own end of a query that took too long; a simulator's errors are JSON.
_TIMED_OUT = b"Timeout"


class Failing(Protocol):
    """What can be given up: a goal under way."""

    def fail(self, error: Exception) -> None:
        """Give it up."""


@dataclass(frozen=True)
class Port:
    """Where a request goes, and what its payload is."""

    key: str
    encoding: str = "application/json"


class Link:
    """A session with what belongs to it: who is there, and what to do later.

    Attributes:
        session: The Zenoh session.
        keys: How keys are spelled.
        worker: For what has to be done later.
        presence: Whether the simulator is there.
        acknowledge_timeout: Wall seconds in which a goal has to be accepted or rejected.
    """

    def __init__(self, session: zenoh.Session, keys: Keys, *, acknowledge_timeout: float, grace: float) -> None:
        self.session = session
        self.keys = keys
        self.worker = Worker("hmrsim client")
        self.presence = Presence(session, keys.alive(), self.worker, grace=grace, on_gone=self._give_up)
        self.acknowledge_timeout = acknowledge_timeout
        self._lock = threading.Lock()
        self._goals: set[Failing] = set()
        self._closers: list[Callable[[], None]] = []
        self._closed = False
        # Not Session.is_closed(): it waits for Zenoh's lock with the GIL held, and who has that lock may want the GIL.
        self._broken = False

    @property
    def closed(self) -> bool:
        """Whether the link or its session was closed, as far as we know."""
        return self._closed or self._broken

    def check_open(self) -> None:
        """Do nothing while the link is open.

        Raises:
            ClientClosed: It is not.
        """
        if self.closed:
            raise ClientClosed("the client is closed")

    def enter(self, goal: Failing) -> None:
        """Take a goal under our wing: it fails when the simulator goes or the link is closed.

        Raises:
            ClientClosed: The link is closed already.
        """
        self.check_open()
        self.presence.start()
        with self._lock:
            # Again, for it may have been closed meanwhile: whom it has in its list by then, it fails.
            self.check_open()
            self._goals.add(goal)

    def leave(self, goal: Failing) -> None:
        """Forget a goal that is done."""
        with self._lock:
            self._goals.discard(goal)

    def subscribe(self, key: str, on_sample: Callable[[zenoh.Sample], None]) -> None:
        """Call a function in Zenoh's thread for each sample, until the link is closed.

        Raises:
            ClientClosed: It is closed already.
        """
        try:
            handler = zenoh.handlers.Callback(on_sample, indirect=False)
            self.on_close(self.session.declare_subscriber(key, handler).undeclare)
        except zenoh.ZError:
            raise ClientClosed("the client is closed") from None

    def on_close(self, closer: Callable[[], None]) -> None:
        """Call a function when the link is closed."""
        with self._lock:
            self._closers.append(closer)

    def ask(self, port: Port, payload: bytes | None, *, timeout: float, then: Callable[[Answer], None]) -> None:
        """Send a request; *then* gets the answer, once: a reply in Zenoh's thread, its absence in the worker's."""
        once = _Once(then, self.worker)
        handler = zenoh.handlers.Callback(once.on_reply, once.on_end, indirect=False)
        try:
            self.session.get(port.key, handler, payload=payload, encoding=port.encoding, timeout=timeout)
        except zenoh.ZError:
            # Our keys are valid, so it is the session: somebody closed it behind our back.
            self._broken = True
            once.on_end()

    def absence(self) -> HmrsimError | None:
        """Return why it is useless to go on; None while the simulator is there or may still come (back)."""
        if self.closed:
            return ClientClosed("the client was closed")
        if not self.presence.gone:
            return None
        token = self.keys.alive()
        if self.presence.seen:
            return SimulatorGone(f"the simulator is gone: its token {token!r} has disappeared")
        return NobodyThere(
            f"no simulator answers: there is no token {token!r}; "
            "start `hmrsim run WORLD`, or check --connect and --prefix"
        )

    def close(self) -> None:
        """Fail what is under way; the session stays open."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            goals, closers = list(self._goals), self._closers
        for goal in goals:
            goal.fail(ClientClosed("the client was closed while the goal was under way"))
        for closer in closers:
            closer()
        self.presence.close()
        self.worker.close()

    def _give_up(self) -> None:
        if error := self.absence():
            with self._lock:
                goals = list(self._goals)
            for goal in goals:
                goal.fail(error)


class _Once:
    """Turns the replies to one query and its end into one answer."""

    def __init__(self, then: Callable[[Answer], None], worker: Worker) -> None:
        self._then: Callable[[Answer], None] | None = then
        self._worker = worker

    def on_reply(self, reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            self._answer(reply.ok.payload.to_bytes())
            return
        body = reply.err.payload.to_bytes() if reply.err is not None else b""
        self._answer(None if body == _TIMED_OUT else RequestError.from_json(body))

    def on_end(self) -> None:
        self._answer(None)

    def _answer(self, answer: Answer) -> None:
        then, self._then = self._then, None
        if then is None:
            return
        if answer is None:
            # Zenoh may end a query with its lock held: whatever used the session in here would wait for ever.
            self._worker.after(0.0, lambda: then(None))
        else:
            then(answer)
