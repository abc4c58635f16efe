"""Queries of a client on keys: bytes there, and bytes, an error or nothing back, in exactly one of these ways."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Final

import zenoh
from pydantic_core import to_json

from hmrsim_zenoh.client.connection import take_within
from hmrsim_zenoh.errors import ClientClosed, Denied, RequestError

if TYPE_CHECKING:
    from hmrsim_zenoh.client.threads import Worker
    from hmrsim_zenoh.wire.enclave import Enclave

Reply = bytes | RequestError | None
"""The reply, the error that was replied, or None: nothing came back, and the request's effect is unknown."""

# Zenoh's own reply to a query that timed out; a simulator's errors are JSON.
_TIMED_OUT: Final = b"Timeout"

_JSON: Final = "application/json"


class QueryCall:
    """A query for whose answer one thread waits.

    No Python runs in Zenoh's callbacks: it would take time, and a KeyboardInterrupt raised there would be lost along
    with the reply.

    Args:
        decode: Returns the answer of a reply.
        silence: Returns the answer if nothing comes back.

    Attributes:
        answer: The answer; None before it arrives, and if it was lost.
    """

    def __init__(
        self,
        decode: Callable[[Reply], object] = lambda reply: reply,
        silence: Callable[[], RequestError | None] = lambda: None,
    ) -> None:
        self.answer: Any = None
        self._decode = decode
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
        if not self._ended:
            try:
                reply = take_within(self._replies, timeout)
            except Empty:
                return False
            self._ended = True
            body = None if reply is None else body_of(reply)
            self.answer = self._silence() if body is None else self._decode(body)
        return True


class Queries:
    """Sends queries on a session.

    Args:
        worker: Runs what must not run in Zenoh's threads.
        enclave: The identity of the client; None where sessions are open.

    Attributes:
        broken: Whether the session is known to be closed.
    """

    def __init__(self, session: zenoh.Session, worker: Worker, enclave: Enclave | None = None) -> None:
        self.session = session
        self.enclave = enclave
        self._worker = worker
        # Not Session.is_closed(): it waits for Zenoh's lock with the GIL held, and the lock's holder may want the GIL.
        self.broken = False

    def note_closed(self) -> None:
        """Record that the session was closed by its owner."""
        self.broken = True

    def ask(
        self,
        key: str,
        payload: bytes | None,
        then: Callable[[Reply], None],
        *,
        timeout: float,
        mime: str = _JSON,
        latest: bool = False,
    ) -> None:
        """Send a query; *then* receives the answer, once: a reply in Zenoh's thread, its absence in the worker's.

        The answer is the first reply, or the *latest* of several, which takes a little longer.
        """
        if self.enclave is not None:
            then = partial(self._explained, key, then)
        once = _Once(then, self._worker)
        handler = zenoh.handlers.Callback(once.on_reply, once.on_end, indirect=False)
        try:
            self._get(key, payload, handler, timeout, mime, latest=latest)
        except zenoh.ZError:
            once.on_end()

    def ask_often(
        self,
        key: str,
        payload: bytes,
        *,
        timeout: float,
        mime: str,
        on_reply: Callable[[bytes | RequestError], None],
        on_end: Callable[[], None],
    ) -> None:
        """Send a query with several replies, taken in Zenoh's thread; at the end no call on the session is allowed.

        A timeout is no reply, just the end.
        """

        def take(reply: zenoh.Reply) -> None:
            if (body := body_of(reply)) is not None:
                on_reply(body)

        try:
            self._get(key, payload, zenoh.handlers.Callback(take, on_end, indirect=False), timeout, mime, latest=False)
        except zenoh.ZError:
            on_end()

    def call(
        self,
        key: str,
        payload: bytes | None,
        *,
        timeout: float,
        mime: str = _JSON,
        latest: bool = False,
        decode: Callable[[Reply], object] = lambda reply: reply,
    ) -> QueryCall:
        """Send a query and return its pending answer."""
        call = QueryCall(decode, partial(self.denial, key))
        try:
            self._get(key, payload, call.handler, timeout, mime, latest=latest)
        except zenoh.ZError:
            call.give_up()
        return call

    def listen(self, key: str, on_payload: Callable[[bytes], None]) -> Callable[[], None]:
        """Call a function in Zenoh's thread for each payload on a key; return a function that ends it.

        Raises:
            ClientClosed: The session is closed.
        """
        handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(
            lambda sample: on_payload(sample.payload.to_bytes()), indirect=False
        )
        try:
            undeclare: Callable[[], None] = self.session.declare_subscriber(key, handler).undeclare
        except zenoh.ZError:
            raise ClientClosed("the client is closed") from None
        return undeclare

    def denial(self, key: str) -> Denied | None:
        """Return why a query that nothing answers is denied; None if access control allows it, or there is none."""
        enclave = self.enclave
        if enclave is None:
            return None
        text = enclave.access_control.denial(enclave.name, key)
        return Denied(text) if text else None

    def _explained(self, key: str, then: Callable[[Reply], None], answer: Reply) -> None:
        then(self.denial(key) if answer is None else answer)

    def _get(
        self,
        key: str,
        payload: bytes | None,
        handler: zenoh.handlers.Callback[zenoh.Reply],
        timeout: float,
        mime: str,
        *,
        latest: bool,
    ) -> None:
        # For the latest reply Zenoh waits for the end of the query, which is a separate message.
        mode = zenoh.ConsolidationMode.AUTO if latest else zenoh.ConsolidationMode.NONE
        try:
            self.session.get(key, handler, payload=payload, encoding=mime, timeout=timeout, consolidation=mode)
        except zenoh.ZError:
            # The keys are valid, so the session is at fault.
            self.note_closed()
            raise


class _Once:
    """Combine the replies to one query and its end into one answer."""

    def __init__(self, then: Callable[[Reply], None], worker: Worker) -> None:
        self._then: Callable[[Reply], None] | None = then
        self._worker = worker

    def on_reply(self, reply: zenoh.Reply) -> None:
        self._answer(body_of(reply))

    def on_end(self) -> None:
        self._answer(None)

    def _answer(self, answer: Reply) -> None:
        then, self._then = self._then, None
        if then is None:
            return
        if answer is None:
            # Zenoh may end a query with its lock held: a call on the session in this callback would deadlock.
            self._worker.after(0.0, lambda: then(None))
        else:
            then(answer)


def body_of(reply: zenoh.Reply) -> Reply:
    """Return the payload or the error of a reply."""
    if (sample := reply.ok) is not None:
        payload, attachment = sample.payload.to_bytes(), sample.attachment
        if attachment is None:
            return payload
        # Why a goal did not succeed comes beside its result, which has the fields of its ROS type.
        cause = to_json(attachment.to_bytes().decode(errors="replace"))
        return b'%b,"cause":%b}' % (payload[:-1], cause)
    body = reply.err.payload.to_bytes() if reply.err is not None else b""
    return None if body == _TIMED_OUT else RequestError.from_json(body)
