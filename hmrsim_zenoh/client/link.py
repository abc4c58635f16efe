"""The session that all goals of a client share, and requests that end in exactly one way."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Final, Protocol

import zenoh
from pydantic_core import to_json

from hmrsim.protocol.goal_ids import made_goal_id
from hmrsim_zenoh.client.liveliness import Presence
from hmrsim_zenoh.client.sim_clock import SimClock
from hmrsim_zenoh.client.subscription import Subscription
from hmrsim_zenoh.client.worker import Rounds, Worker
from hmrsim_zenoh.errors import ClientClosed, Denied, RequestError, SimulatorGone, SimulatorNotFound
from hmrsim_zenoh.loopback.session import LoopbackSession

if TYPE_CHECKING:
    from hmrsim.errors import HmrsimError
    from hmrsim_zenoh.wire.enclave import Enclave
    from hmrsim_zenoh.wire.keys import Keys

Answer = bytes | RequestError | None
"""The reply, the error that was replied, or None: nothing came back, and the request's effect is unknown."""

# Zenoh's own reply to a query that timed out; a simulator's errors are JSON.
_TIMED_OUT = b"Timeout"

_ROUND: Final = 3.0
_LOOK: Final = 1.0
"""Wall seconds until a wait begins anew: one that begins as Ctrl-C is pressed may not be interrupted."""


class Failing(Protocol):
    """An activity that can be failed: an active goal, or participation in lockstep."""

    def fail(self, error: Exception) -> None:
        """Fail it."""


class Wire(Protocol):
    """The transport of a goal handle's requests.

    Attributes:
        ordered: Whether requests arrive in the order in which they are sent.
    """

    ordered: bool

    def ask(self, port: Port, payload: bytes, *, timeout: float, then: Callable[[Answer], None]) -> None:
        """Send a request; *then* receives the answer, once."""

    def look_up(self, port: Port, payload: bytes, *, timeout: float, then: Callable[[Answer], None]) -> None:
        """Query a value that will never change; *then* receives the answer, once."""

    def listen(self, key: str, on_payload: Callable[[bytes], None], wanted: Callable[[], bool]) -> None:
        """Call a function for each payload on a key, at least while it is *wanted*."""

    def drive(self, condition: Callable[[], bool], timeout: float | None, *, at_once: bool = False) -> bool:
        """Make the progress that a condition needs; return whether it holds."""

    def drive_within(self, condition: Callable[[], bool], timeout: float | None, sim_timeout: float) -> float:
        """Likewise, for so many simulated seconds at most; return how many of them are left."""


@dataclass(frozen=True)
class Port:
    """The key and the payload of a request.

    Attributes:
        at_once: Whether the first reply is the answer, and is taken as it comes. Otherwise the latest one is: Zenoh
            holds replies until the end of the query, which comes in a message of its own.
    """

    key: str
    encoding: str = "application/json"
    at_once: bool = False


class Call:
    """A request for whose answer one thread waits.

    No Python runs in Zenoh's callbacks: it would take time, and a KeyboardInterrupt raised there would be lost along
    with the reply.

    Args:
        silence: Returns the answer if nothing comes back.

    Attributes:
        answer: The answer; None while there is none, too.
    """

    def __init__(self, silence: Callable[[], Answer] = lambda: None) -> None:
        self.answer: Answer = None
        self._silence = silence
        self._replies: SimpleQueue[zenoh.Reply | None] = SimpleQueue()
        self._ended = False
        self.handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            self._replies.put, partial(self._replies.put, None), indirect=False
        )

    def give_up(self) -> None:
        """End the request without an answer; from any thread."""
        self._replies.put(None)

    def wait(self, timeout: float) -> bool:
        """Return whether there is an answer, or will be none, within *timeout* wall seconds."""
        limit = time.monotonic() + timeout
        while not self._ended:
            left = max(0.0, limit - time.monotonic())
            try:
                reply = self._replies.get(timeout=min(left, _LOOK))
            except Empty:
                if left <= _LOOK:
                    return False
                continue
            self._ended = True
            answer = None if reply is None else _answer(reply)
            self.answer = self._silence() if answer is None else answer
        return True


class Link:
    """A session with its worker thread and the simulator's liveliness.

    Attributes:
        worker: Runs deferred calls.
        rounds: Runs those that may wait for some seconds.
        presence: Whether the simulator is alive.
        acknowledge_timeout: Wall seconds within which a goal has to be accepted or rejected.
    """

    ordered = False

    def __init__(
        self,
        session: zenoh.Session,
        keys: Keys,
        *,
        acknowledge_timeout: float,
        grace: float,
        enclave: Enclave | None = None,
    ) -> None:
        self.session = session
        self._enclave = enclave
        self.keys = keys
        self.worker = Worker("hmrsim client", at_once=not isinstance(session, LoopbackSession))
        self.rounds = Rounds(self.worker, _ROUND)
        self.presence = Presence(session, keys.alive(), self.worker, grace=grace, on_gone=self._give_up)
        self.acknowledge_timeout = acknowledge_timeout
        self._lock = threading.Lock()
        # Ordered, so that goals fail in order.
        self._goals: dict[Failing, None] = {}
        # Zenoh's timestamps contain the session's id and are unique within it.
        self._owner = str(session.new_timestamp())
        self._sent = 0
        self._closers: list[Callable[[], None]] = []
        self._subscriptions: list[Subscription] = []
        self._closed = False
        # Not Session.is_closed(): it waits for Zenoh's lock with the GIL held, and the lock's holder may want the GIL.
        self._broken = False

    @property
    def closed(self) -> bool:
        """Whether the link or its session is known to be closed."""
        return self._closed or self._broken

    def check_open(self) -> None:
        """Check that the link is open.

        Raises:
            ClientClosed: It is not.
        """
        if self.closed:
            raise ClientClosed("the client is closed")

    def enter(self, goal: Failing) -> None:
        """Track a goal: it fails when the simulator goes or the link is closed.

        Raises:
            ClientClosed: The link is closed already.
        """
        self.check_open()
        self.presence.start()
        with self._lock:
            # Checked again: closing fails only the goals that are tracked by then.
            self.check_open()
            self._goals[goal] = None

    def leave(self, goal: Failing) -> None:
        """Stop tracking a goal that is done."""
        with self._lock:
            self._goals.pop(goal, None)

    def listen(self, key: str, on_payload: Callable[[bytes], None], _wanted: Callable[[], bool]) -> None:
        """Call a function in Zenoh's thread for each payload on a key, until the link is closed.

        Raises:
            ClientClosed: It is closed already.
        """
        handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(
            lambda sample: on_payload(sample.payload.to_bytes()), indirect=False
        )
        try:
            self.on_close(self.session.declare_subscriber(key, handler).undeclare)
        except zenoh.ZError:
            raise ClientClosed("the client is closed") from None

    def drive(self, condition: Callable[[], bool], _timeout: float | None, *, at_once: bool = False) -> bool:  # noqa: ARG002 - as a wire
        """Return whether a condition holds; time moves by itself, so there is nothing to advance."""
        return condition()

    def drive_within(self, _condition: Callable[[], bool], _timeout: float | None, sim_timeout: float) -> float:
        """Return *sim_timeout*; time moves by itself, so there is nothing to advance."""
        return sim_timeout

    def alarm(self, seconds: float, ring: Callable[[], None]) -> SimClock:
        """Call a function once so many simulated seconds have passed, until the clock is closed.

        Raises:
            ClientClosed: The link is closed.
        """
        end = math.inf

        def on_time(now: float) -> None:
            nonlocal end
            if end == math.inf:
                end = now + seconds
            if now >= end:
                ring()

        return SimClock(self, on_time)

    def subscribe(self, key: str, callback: Callable[[str, bytes], None], *, history: bool = False) -> Subscription:
        """Call back with the key and payload of each sample, in a thread of its own, until that or the link is closed.

        Raises:
            ClientClosed: The link is closed.
        """
        self.check_open()
        try:
            subscription = Subscription(self.session, key, callback, history=history)
        except zenoh.ZError:
            raise ClientClosed("the client is closed") from None
        with self._lock:
            self._subscriptions = [*(each for each in self._subscriptions if not each.closed), subscription]
        return subscription

    def next_goal_id(self) -> str:
        """Return a goal id that is unique across all clients."""
        with self._lock:
            self._sent += 1
            return made_goal_id(self._owner, self._sent)

    def on_close(self, closer: Callable[[], None]) -> None:
        """Call a function when the link is closed."""
        with self._lock:
            self._closers.append(closer)

    def ask(self, port: Port, payload: bytes | None, *, timeout: float, then: Callable[[Answer], None]) -> None:
        """Send a request; *then* receives the answer, once: a reply in Zenoh's thread, its absence in the worker's."""
        if self._enclave is not None:
            then = partial(self._explained, port.key, then)
        once = _Once(then, self.worker)
        handler = zenoh.handlers.Callback(once.on_reply, once.on_end, indirect=False)
        try:
            self._get(port, payload, handler, timeout)
        except zenoh.ZError:
            once.on_end()

    look_up = ask

    def ask_often(
        self,
        port: Port,
        payload: bytes,
        *,
        timeout: float,
        on_reply: Callable[[bytes | RequestError], None],
        on_end: Callable[[], None],
    ) -> None:
        """Send a request with several replies, taken in Zenoh's thread; at the end no call on the session is allowed.

        A timeout is no reply, just the end.
        """

        def take(reply: zenoh.Reply) -> None:
            if (answer := _answer(reply)) is not None:
                on_reply(answer)

        try:
            self._get(port, payload, zenoh.handlers.Callback(take, on_end, indirect=False), timeout)
        except zenoh.ZError:
            on_end()

    def call(self, port: Port, payload: bytes | None, *, timeout: float) -> Call:
        """Send a request and return its pending reply."""
        call = Call(partial(self.denial, port.key))
        try:
            self._get(port, payload, call.handler, timeout)
        except zenoh.ZError:
            call.give_up()
        return call

    def time_key(self, request: str) -> str:
        """Return the key of a request about time."""
        member = self._enclave.member if self._enclave else None
        by_name = request == "advance" and member is not None and member.role == "controller"
        return self.keys.world(f"time/{request}/{member.name}" if by_name and member else f"time/{request}")

    @property
    def is_local_and_alive(self) -> bool:
        """Whether the simulator is within this process and there, so that it answers at once or not at all."""
        return isinstance(self.session, LoopbackSession) and self.presence.is_there

    def absence(self) -> HmrsimError | None:
        """Return why no answer can come any more; None while the simulator is alive or may still come (back)."""
        if self.closed:
            return ClientClosed("the client was closed")
        if not self.presence.gone:
            return None
        token = self.keys.alive()
        if self.presence.seen:
            return SimulatorGone(f"the simulator is gone: its token {token!r} has disappeared")
        return SimulatorNotFound(f"no simulator answers: {self.unseen}")

    @property
    def unseen(self) -> str:
        """Why there may be no simulator, and what would do."""
        token = self.keys.alive()
        if self._enclave is None:
            return f"there is no token {token!r}; start `hmrsim run WORLD`, or check --connect and --prefix"
        return (
            f"there is no token {token!r}, or it is hidden from {self._enclave.name!r}, who may be revoked; "
            "ask `hmrsim security explain`, or check --prefix"
        )

    def denial(self, key: str) -> Denied | None:
        """Return why a request that nothing answers is denied; None if access control allows it, or there is none."""
        enclave = self._enclave
        if enclave is None:
            return None
        text = enclave.access_control.denial(enclave.name, key)
        return Denied(text) if text else None

    def _explained(self, key: str, then: Callable[[Answer], None], answer: Answer) -> None:
        then(self.denial(key) if answer is None else answer)

    def close(self) -> None:
        """Fail everything under way; the session stays open."""
        with self._lock:
            if self._closed:
                return
            self._closed = True
            closers = [*self._closers, *(each.close for each in self._subscriptions)]
        self.fail(ClientClosed("the client was closed while the goal was under way"))
        for closer in closers:
            closer()
        self.presence.close()
        self.worker.close()

    def fail(self, error: Exception) -> None:
        """Fail everything under way."""
        with self._lock:
            goals = list(self._goals)
        for goal in goals:
            goal.fail(error)

    def _get(
        self, port: Port, payload: bytes | None, handler: zenoh.handlers.Callback[zenoh.Reply], timeout: float
    ) -> None:
        mode = zenoh.ConsolidationMode.NONE if port.at_once else zenoh.ConsolidationMode.AUTO
        try:
            self.session.get(
                port.key, handler, payload=payload, encoding=port.encoding, timeout=timeout, consolidation=mode
            )
        except zenoh.ZError:
            # The keys are valid, so the session is at fault: its owner has closed it.
            self._broken = True
            raise

    def _give_up(self) -> None:
        if error := self.absence():
            self.fail(error)


class _Once:
    """Combine the replies to one query and its end into one answer."""

    def __init__(self, then: Callable[[Answer], None], worker: Worker) -> None:
        self._then: Callable[[Answer], None] | None = then
        self._worker = worker

    def on_reply(self, reply: zenoh.Reply) -> None:
        self._answer(_answer(reply))

    def on_end(self) -> None:
        self._answer(None)

    def _answer(self, answer: Answer) -> None:
        then, self._then = self._then, None
        if then is None:
            return
        if answer is None:
            # Zenoh may end a query with its lock held: a call on the session in this callback would deadlock.
            self._worker.after(0.0, lambda: then(None))
        else:
            then(answer)


def _answer(reply: zenoh.Reply) -> Answer:
    if (sample := reply.ok) is not None:
        payload, attachment = sample.payload.to_bytes(), sample.attachment
        if attachment is None:
            return payload
        # Why a goal did not succeed comes beside its result, which has the fields of its ROS type.
        cause = to_json(attachment.to_bytes().decode(errors="replace"))
        return b'%b,"cause":%b}' % (payload[:-1], cause)
    body = reply.err.payload.to_bytes() if reply.err is not None else b""
    return None if body == _TIMED_OUT else RequestError.from_json(body)
