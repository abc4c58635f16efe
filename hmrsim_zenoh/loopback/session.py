"""A session within the process, with what is used here of `zenoh.Session`."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Final, Protocol, Self

import zenoh

from hmrsim_zenoh.loopback.exchange import Kind

if TYPE_CHECKING:
    from hmrsim_zenoh.loopback.delivery import Delivery
    from hmrsim_zenoh.loopback.exchange import Declaration, Exchange


class Pending:
    """A command that awaits its answer.

    Attributes:
        may_be_lost: Whether the answer may get lost on its way.
    """

    __slots__ = ("may_be_lost", "session")

    def __init__(self, session: LoopbackSession) -> None:
        self.session = session
        self.may_be_lost = False

    def take(self, answer: Any) -> None:
        """Take the answer, once: None if it is lost, a `RequestError` if the command can't be served."""
        raise NotImplementedError


class Simulation(Protocol):
    """The simulation of a process, as its sessions reach it."""

    @property
    def exchange(self) -> Exchange:
        """The declarations of all sessions; the first use begins to serve keys."""

    @property
    def delivery(self) -> Delivery:
        """Runs the simulation, and delivers its messages while it pauses."""

    def send(self, command: Any, pending: Pending) -> None:
        """Send a command; *pending* takes its answer while the simulation does not run."""

    def announce(self, name: str, *, alive: bool) -> None:
        """Report that a participant has come or gone."""

    def follow(self, on_change: Callable[[bool], None]) -> Callable[[], None]:
        """Report whether the simulation serves its clients, now and when it ends; return a function to stop that."""


class LoopbackSession:
    """A session with the simulation of this process. Requests are answered, if possible, before a call returns.

    Commands go to the simulation as objects. On keys it passes for a session of Zenoh, with what is used of that here.

    Args:
        simulation: The simulation.
        waits: Returns whether the session has to wait before it sends, because other threads come first.

    Attributes:
        simulation: The simulation; read-only.
        error: The error with which the session was cut off, so that it receives nothing; None if it was not.
    """

    def __init__(self, simulation: Simulation, waits: Callable[[], bool] | None = None) -> None:
        self.simulation = simulation
        self.error: BaseException | None = None
        self._delivery = simulation.delivery
        self._waits = waits
        self._number = self._delivery.number()
        self._participants: dict[str, None] = {}
        self._tokens: list[Token] = []
        self._declared: list[Declaration] = []
        self._closed = False

    @property
    def exchange(self) -> Exchange:
        """The declarations of all sessions of the process."""
        return self.simulation.exchange

    def close(self) -> None:
        """Withdraw all that the session has declared and announced."""
        if not self._closed:
            self._closed = True
            for name in list(self._participants):
                self._withdraw(name)
            for token in self._tokens:
                token.undeclare()
            for declared in self._declared:
                declared.undeclare()
            self._delivery.settle()

    def cut(self, error: BaseException) -> None:
        """Cut the session off at once, as the end of its process would; the simulation may call it, too.

        Its participants are gone, it receives nothing further, and each call raises *error*, including calls in
        progress.
        """
        if self._closed:
            return
        self._closed, self.error = True, error
        for declared in self._declared:
            declared.undeclare()
        for token in self._tokens:
            token.lose()
        for name in list(self._participants):
            self._withdraw(name)
        self._delivery.notify()

    def is_closed(self) -> bool:
        """Return whether the session was closed."""
        return self._closed

    def new_timestamp(self) -> str:
        """Return a text that no session of the process has returned before."""
        return f"{self._delivery.number()}/{self._number}"

    def submit(self, command: Any, pending: Pending) -> None:
        """Send the simulation a command; *pending* takes its answer, once, unless the session was cut off.

        Raises:
            zenoh.ZError: The session is closed.
        """
        if self._closed or self._waits is not None:
            self._check()
        self.simulation.send(command, pending)
        if self.error is not None:
            raise self.error

    def announce(self, name: str) -> Callable[[], None]:
        """Announce a participant; return a function that withdraws the announcement.

        Raises:
            zenoh.ZError: The session is closed.
        """
        self._check()
        self._participants[name] = None
        # It is processed before what the participant sends next.
        self.simulation.announce(name, alive=True)
        return partial(self._take_leave, name)

    def _take_leave(self, name: str) -> None:
        if name in self._participants:
            self._withdraw(name)
            self._settle()

    def _withdraw(self, name: str) -> None:
        del self._participants[name]
        self.simulation.announce(name, alive=False)

    def declare_keyexpr(self, key: str) -> str:
        """Return a key: they need not be declared here."""
        return key

    def put(self, key: object, payload: Any, *, encoding: object = "", **_: object) -> None:
        """Publish a sample to all subscribers."""
        self._check()
        name = str(key)
        found = self.exchange.matching(Kind.SUBSCRIBER, name)
        if found:
            sample = Sample(name, Payload.of(payload), str(encoding))
            for each in found:
                self._delivery.deliver(each.call, sample)
            self._settle()

    def get(
        self,
        key: object,
        handler: zenoh.handlers.Callback[Any] | None = None,
        *,
        among: Callable[[Declaration], bool] = lambda _declaration: True,
        **sent: Any,
    ) -> Iterator[Reply]:
        """Send a query; without a handler the replies are returned.

        Args:
            key: A key expression.
            handler: Receives the replies, and their end.
            among: Selects the queryables to query.
            **sent: The *payload*, *encoding* and *attachment* of the query; other options of Zenoh mean nothing here.
        """
        self._check()
        delivery, name = self._delivery, str(key)
        replies: list[Reply] = []
        take = self._heard(replies.append if handler is None else handler.callback)
        found = [each for each in self.exchange.matching(Kind.QUERYABLE, name) if among(each)]
        left = len(found)

        def end() -> None:
            nonlocal left
            left -= 1
            if left <= 0 and handler is not None and handler.drop is not None:
                delivery.deliver(lambda drop: drop(), handler.drop)

        for each in found:
            each.call(Query(name, sent, partial(delivery.deliver, take), end))
        if not found:
            end()
        self._settle()
        return iter(replies)

    def declare_subscriber(self, key: str, handler: Any) -> Declaration:
        """Declare a subscriber, and return it."""
        return self._declare(Kind.SUBSCRIBER, key, _taker(handler))

    def declare_queryable(self, key: str, handler: Any, **_: object) -> Declaration:
        """Declare a queryable, and return it."""
        return self._declare(Kind.QUERYABLE, key, _taker(handler))

    def declare_querier(self, key: str, **_: object) -> Querier:
        """Return a querier for the queryables of the other sessions on a key."""
        return Querier(self, key)

    def liveliness(self) -> Liveliness:
        """Return the liveliness tokens of the exchange."""
        return Liveliness(self)

    def _declare(self, kind: Kind, key: str, call: Callable[[Any], object]) -> Declaration:
        self._check()
        declaration = self.exchange.declare(kind, key, self._heard(call), self)
        self._declared.append(declaration)
        return declaration

    def _declare_token(self, key: str) -> Token:
        self._check()
        token = Token(self.exchange, self._delivery, self.exchange.declare(Kind.TOKEN, key, _ignore, self))
        self._tokens.append(token)
        return token

    def _check(self) -> None:
        if self._waits is not None:
            self._delivery.wait_while(lambda: not self._closed and self._waits is not None and self._waits())
        self._check_cut()
        if self._closed:
            raise zenoh.ZError("the session is closed")

    def _settle(self) -> None:
        self._delivery.settle()
        self._check_cut()

    def _check_cut(self) -> None:
        if self.error is not None:
            raise self.error

    def _heard(self, take: Callable[[Any], object]) -> Callable[[Any], object]:
        """Return a callback that ignores its message once the session was cut off."""
        return lambda item: take(item) if self.error is None else None


class Liveliness:
    """The liveliness tokens of an exchange, as a session has them."""

    def __init__(self, session: LoopbackSession) -> None:
        self._session = session
        self._exchange = session.exchange
        self._delivery = session.simulation.delivery

    def declare_token(self, key: str) -> Token:
        """Declare a token of this session."""
        return self._session._declare_token(key)  # noqa: SLF001 - a part of the session

    def declare_subscriber(self, key: str, handler: Any, *, history: bool = False) -> Declaration:
        """Declare a subscriber to tokens that come and go; *history* includes the tokens that exist already."""
        take = _taker(handler)
        declaration = self._session._declare(Kind.TOKEN_SUBSCRIBER, key, take)  # noqa: SLF001 - as above
        if history:
            for each in self._exchange.matching(Kind.TOKEN, key):
                self._delivery.deliver(take, Sample(str(each.key_expr)))
            self._delivery.settle()
        return declaration

    def get(self, key: str, handler: zenoh.handlers.Callback[Any], **_: object) -> None:
        """Query the tokens that exist."""
        for each in self._exchange.matching(Kind.TOKEN, key):
            self._delivery.deliver(handler.callback, Reply(ok=Sample(str(each.key_expr))))
        if handler.drop is not None:
            self._delivery.deliver(lambda drop: drop(), handler.drop)
        self._delivery.settle()


class Token:
    """A liveliness token of a session."""

    def __init__(self, exchange: Exchange, delivery: Delivery, declaration: Declaration) -> None:
        self._exchange = exchange
        self._delivery = delivery
        self._declaration = declaration
        self._key = str(declaration.key_expr)
        self._announce(zenoh.SampleKind.PUT)

    def undeclare(self) -> None:
        """Withdraw the token; a second call has no effect."""
        if self._declaration.undeclare():
            self._announce(zenoh.SampleKind.DELETE)

    def lose(self) -> None:
        """Withdraw the token from within the simulation, which learns of it at once."""
        if self._declaration.undeclare():
            for each in self._exchange.matching(Kind.TOKEN_SUBSCRIBER, self._key):
                each.call(Sample(self._key, kind=zenoh.SampleKind.DELETE))

    def _announce(self, kind: zenoh.SampleKind) -> None:
        for each in self._exchange.matching(Kind.TOKEN_SUBSCRIBER, self._key):
            self._delivery.deliver(each.call, Sample(self._key, kind=kind))
        self._delivery.settle()


class Querier:
    """Queries the other sessions on one key."""

    def __init__(self, session: LoopbackSession, key: str) -> None:
        self._session = session
        self._key = key

    @property
    def matching_status(self) -> SimpleNamespace:
        """The status that says whether another session has a queryable on the key."""
        found = self._session.exchange.matching(Kind.QUERYABLE, self._key)
        return SimpleNamespace(matching=any(map(self._is_others, found)))

    def declare_matching_listener(self, handler: object) -> None:
        """Do nothing: the status is read before each request."""

    def get(self, handler: zenoh.handlers.Callback[Any], **sent: Any) -> None:
        """Send a query to the queryables of the other sessions."""
        self._session.get(self._key, handler, among=self._is_others, **sent)

    def _is_others(self, declaration: Declaration) -> bool:
        return declaration.owner is not self._session


def _taker(handler: Any) -> Callable[[Any], object]:
    call: Callable[[Any], object] = handler.callback if isinstance(handler, zenoh.handlers.Callback) else handler
    return call


def _ignore(_item: object) -> None:
    """Ignore a message to a token."""


class Payload(bytes):
    """Bytes, as `zenoh.ZBytes` has them."""

    __slots__ = ()

    @classmethod
    def of(cls, payload: Any) -> Self:
        """Return a payload of whatever Zenoh takes as one."""
        if isinstance(payload, cls):
            return payload
        return cls(payload.encode()) if isinstance(payload, str) else cls(bytes(payload))

    def to_bytes(self) -> bytes:
        """Return it."""
        return self


EMPTY: Final = Payload()


@dataclass(frozen=True, slots=True)
class Sample:
    """A value on a key, or a liveliness token that has come or gone."""

    key_expr: str
    payload: Payload = EMPTY
    encoding: str = ""
    kind: zenoh.SampleKind = field(default_factory=lambda: zenoh.SampleKind.PUT)
    timestamp: str | None = None
    attachment: Payload | None = None


@dataclass(frozen=True, slots=True)
class ReplyError:
    """The payload of an error reply."""

    payload: Payload
    encoding: str = ""


@dataclass(frozen=True, slots=True)
class Reply:
    """The reply to a query: a sample or an error."""

    ok: Sample | None = None
    err: ReplyError | None = None


class Query:
    """A query at one queryable; it ends when it is dropped or garbage-collected.

    Args:
        sent: Its payload, encoding and attachment, as far as it has them.
        on_reply: Takes each reply.
        on_end: Called once, at the end.
    """

    __slots__ = ("_on_end", "_on_reply", "attachment", "encoding", "key_expr", "payload")

    def __init__(
        self, key_expr: str, sent: Mapping[str, Any], on_reply: Callable[[Reply], None], on_end: Callable[[], None]
    ) -> None:
        payload, attachment = sent.get("payload"), sent.get("attachment")
        self.key_expr = key_expr
        self.payload = None if payload is None else Payload.of(payload)
        self.attachment = None if attachment is None else Payload.of(attachment)
        self.encoding = str(sent.get("encoding") or "")
        self._on_reply = on_reply
        self._on_end: Callable[[], None] | None = on_end

    def __del__(self) -> None:
        """End the query, as a query of Zenoh does."""
        self.drop()

    def reply(
        self,
        key: object,
        payload: Any,
        *,
        encoding: object = "",
        timestamp: str | None = None,
        attachment: bytes | None = None,
    ) -> None:
        """Send a sample as a reply."""
        attached = None if attachment is None else Payload.of(attachment)
        sample = Sample(str(key), Payload.of(payload), str(encoding), timestamp=timestamp, attachment=attached)
        self._on_reply(Reply(ok=sample))

    def reply_err(self, payload: Any, *, encoding: object = "") -> None:
        """Send an error as a reply."""
        self._on_reply(Reply(err=ReplyError(Payload.of(payload), str(encoding))))

    def drop(self) -> None:
        """End the query; no further replies are sent."""
        on_end, self._on_end = self._on_end, None
        if on_end is not None:
            on_end()
