"""The connection to a simulator in this process: commands go to its inbox, and answers come back directly."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Protocol

import zenoh

from hmrsim.protocol.commands import CallService
from hmrsim.protocol.goal import Refused
from hmrsim.protocol.outputs import Granted, Receiver
from hmrsim_zenoh.client.connection import Ask, Connection, Read, body_of
from hmrsim_zenoh.client.exchange import Kind, LocalReply, Payload, Query, Sample
from hmrsim_zenoh.errors import ClientClosed, RequestError
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.session import unless_closed

if TYPE_CHECKING:
    from hmrsim_zenoh.client.connection import ActionTarget, Answer, Asked, GoalCommand, Reply
    from hmrsim_zenoh.client.exchange import Declaration, Delivery, Exchange


class Pending(Receiver):
    """A command that awaits its answer.

    Attributes:
        may_be_lost: Whether the answer may get lost on its way.
    """

    __slots__ = ("_connection", "_then", "may_be_lost")

    def __init__(self, connection: LocalConnection, then: Callable[[Answer], None]) -> None:
        self._connection = connection
        self._then: Callable[[Answer], None] | None = then
        self.may_be_lost = False

    def succeed(self, answer: Any) -> None:
        """Deliver an answer of the simulation once that pauses, unless it gets lost."""
        if type(answer) is Refused or (type(answer) is Granted and Refused in map(type, answer.accepted)):
            answer = for_client(answer)
        simulation = self._connection.simulation
        lost = self.may_be_lost and simulation.loses_answer()
        simulation.delivery.deliver(self.take, None if lost else answer)

    def take(self, answer: Answer) -> None:
        """Pass on the first answer unless the connection was cut off; None for one that is lost."""
        then, self._then = self._then, None
        if then is not None and self._connection.error is None:
            then(answer)


class LocalCall(Pending):
    """A request whose answer has usually arrived when the call returns.

    Attributes:
        answer: The answer; None before it arrives, and if it was lost.
    """

    __slots__ = ("_ended", "answer")

    def __init__(self, connection: LocalConnection) -> None:
        # The same as in the base class, without a call of its constructor for each advance.
        self._connection, self.may_be_lost = connection, False
        self.answer: Answer = None
        self._ended = False

    def take(self, answer: Answer) -> None:
        """Take the answer, unless the connection was cut off."""
        if not self._ended and self._connection.error is None:
            self.answer, self._ended = answer, True

    def give_up(self) -> None:
        """End the request without an answer; from any thread."""
        self.take(None)
        self._connection.simulation.delivery.notify()

    def wait(self, timeout: float) -> bool:
        """Return whether there is an answer, or will be none, within *timeout* wall seconds."""
        if not self._ended:
            # Another thread has to advance time first.
            self._connection.wait_while(lambda: not self._ended, timeout)
        return self._ended


class Simulation(Protocol):
    """The simulation of a process, as its connections use it."""

    @property
    def exchange(self) -> Exchange:
        """The declarations of all connections; the first use begins to serve keys."""

    @property
    def delivery(self) -> Delivery:
        """Runs the simulation, and delivers its messages while it pauses."""

    def send(self, command: Any, pending: Pending) -> None:
        """Send a command; *pending* takes its answer while the simulation does not run."""

    def loses_answer(self) -> bool:
        """Return whether the current answer is lost, and count it."""

    def announce(self, name: str, *, alive: bool) -> None:
        """Report that a participant has come or gone."""

    def follow(self, on_change: Callable[[bool], None]) -> Callable[[], object]:
        """Report whether the simulation serves its clients, now and when it ends; return a function to stop that."""


class LocalConnection(Connection):
    """A connection to the simulation of this process, which answers requests before a call returns if it can.

    Commands go to the simulation as objects. For keys it has those methods of a Zenoh session that are used here.

    Args:
        waits: Returns whether to wait before anything is sent, because other threads come first.

    Attributes:
        simulation: The simulation; read-only.
        error: The error with which the connection was cut off, so that it receives nothing; None if it was not.
    """

    in_process = True

    def __init__(self, simulation: Simulation, waits: Callable[[], bool] | None = None) -> None:
        self.error: BaseException | None = None
        self.broken = False
        self.simulation = simulation
        self._delivery = simulation.delivery
        self._waits = waits
        self._number = self._delivery.number()
        self._participants: dict[str, None] = {}
        self._declared: list[Declaration] = []
        self._closed = False

    def send(
        self,
        target: ActionTarget,  # noqa: ARG002 - the command names it
        command: GoalCommand,
        then: Callable[[Answer], None],
        **_options: Any,
    ) -> None:
        """Send a command to the simulator's inbox; there is no answer to read or to wait for."""
        self._submit(command, Pending(self, then))

    def listen(self, target: ActionTarget) -> None:
        """Do nothing: in one process time moves in lockstep only, which delivers the feedback."""

    def unlisten(self) -> None:
        """Do nothing: there are no listeners."""

    def call(self, command: Asked, **_options: float) -> LocalCall:
        """Send a command whose answer a thread waits for."""
        call = LocalCall(self)
        if isinstance(command, Read):
            self._query(command, call)
        else:
            self._submit(CallService(command.service, command.request) if isinstance(command, Ask) else command, call)
        return call

    def ask(self, request: Read, then: Callable[[Reply], None], **_options: float) -> None:
        """Send a request on a key; *then* receives the answer."""
        self._query(request, Pending(self, then))

    def subscribe(self, key: str, take: Callable[[str, bytes], None], *, history: bool = False) -> Callable[[], object]:
        """Call a function with the key and payload of each sample; return a function that unsubscribes."""

        def on_sample(sample: Any) -> None:
            take(str(sample.key_expr), sample.payload.to_bytes())

        with unless_closed():
            for reply in self.get(key) if history else ():
                if reply.ok is not None:
                    on_sample(reply.ok)
            return self.declare_subscriber(key, on_sample).undeclare

    def token(self) -> str:
        """Return a text that no other connection has."""
        return self.new_timestamp()

    def announce(self, name: str) -> Callable[[], None]:
        """Announce a participant; return a function that withdraws the announcement."""
        if not self._open():
            raise ClientClosed("the client is closed")
        self._participants[name] = None
        # It is processed before what the participant sends next.
        self.simulation.announce(name, alive=True)
        return partial(self._take_leave, name)

    def follow(self, on_change: Callable[[bool], None]) -> Callable[[], object]:
        """Report whether the simulator is alive, now and whenever that changes; return a function to stop that."""
        if not self._open():
            raise ClientClosed("the client is closed")
        return self.simulation.follow(on_change)

    def look(self, on_alive: Callable[[], None], then: Callable[[], None], **_options: float) -> None:
        """Call *on_alive* if the simulator is alive, and *then* in any case."""
        self.simulation.follow(lambda alive: on_alive() if alive else None)()
        then()

    def wait_while(self, holds: Callable[[], bool], timeout: float = math.inf) -> None:
        """Wait for other threads while a condition holds, at most *timeout* wall seconds, unless the connection ends.

        Raises:
            BaseException: The error with which the connection was cut off, also if that is during the wait.
        """
        self._delivery.wait_while(lambda: self.error is None and holds(), timeout)
        if self.error is not None:
            raise self.error

    def close(self) -> None:
        """Withdraw everything that was declared and announced."""
        if not self._closed:
            self._closed = self.broken = True
            self._withdraw()
            self._delivery.settle()

    def cut(self, error: BaseException) -> None:
        """Cut the connection off at once, as the end of its process would; the simulation may call it, too.

        Its participants are gone, it receives nothing further, and each call raises *error*, including calls in
        progress.
        """
        if not self._closed:
            self._closed, self.error = True, error
            self._withdraw()
            self._delivery.notify()

    def new_timestamp(self) -> str:
        """Return a text that no connection of the process has returned before."""
        return f"{self._delivery.number()}/{self._number}"

    def declare_keyexpr(self, key: str) -> str:
        """Return the key itself: keys need not be declared here."""
        return key

    def put(self, key: object, payload: Any, *, encoding: object = "", **_: object) -> None:
        """Publish a sample to all subscribers."""
        self._check()
        found = self.simulation.exchange.matching(Kind.SUBSCRIBER, str(key))
        if found:
            sample = Sample(str(key), Payload.of(payload), str(encoding))
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
    ) -> Iterator[LocalReply]:
        """Send a query; without a handler the replies are returned.

        Args:
            key: A key expression.
            handler: Receives the replies, and their end.
            among: Selects the queryables to query.
            **sent: The *payload*, *encoding* and *attachment* of the query; other options of Zenoh mean nothing here.
        """
        self._check()
        delivery, name = self._delivery, str(key)
        replies: list[LocalReply] = []
        take = self._heard(replies.append if handler is None else handler.callback)
        found = [each for each in self.simulation.exchange.matching(Kind.QUERYABLE, name) if among(each)]
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

    def declare(self, kind: Kind, key: str, handler: Any) -> Declaration:
        """Declare something, and return it."""
        self._check()
        call = handler.callback if isinstance(handler, zenoh.handlers.Callback) else handler
        declaration = self.simulation.exchange.declare(kind, key, self._heard(call), self)
        self._declared.append(declaration)
        return declaration

    def declare_subscriber(self, key: str, handler: Any) -> Declaration:
        """Declare a subscriber, and return it."""
        return self.declare(Kind.SUBSCRIBER, key, handler)

    def declare_queryable(self, key: str, handler: Any, **_: object) -> Declaration:
        """Declare a queryable, and return it."""
        return self.declare(Kind.QUERYABLE, key, handler)

    def declare_querier(self, key: str, **_: object) -> LocalQuerier:
        """Return a querier for the queryables of the other connections on a key."""
        return LocalQuerier(self, key)

    def liveliness(self) -> Liveliness:
        """Return the liveliness tokens of the process."""
        return Liveliness(self)

    def _query(self, request: Read, pending: Pending) -> None:
        handler: Any = zenoh.handlers.Callback(
            lambda reply: pending.take(body_of(reply)), partial(pending.take, None), indirect=False
        )
        try:
            self.get(request.key, handler, payload=request.payload, encoding=encoding.JSON)
        except zenoh.ZError:
            pending.take(None)

    def _submit(self, command: Any, pending: Pending) -> None:
        """Send the simulation a command; *pending* takes its answer, once, unless the connection was cut off."""
        if (self._closed or self._waits is not None) and not self._open():
            pending.take(None)
            return
        self.simulation.send(command, pending)
        if self.error is not None:
            raise self.error

    def _open(self) -> bool:
        """Return whether something can be sent, once other threads that come first have had their turn."""
        if (waits := self._waits) is not None:
            self.wait_while(lambda: not self._closed and waits())
        if self.error is not None:
            raise self.error
        return not self._closed

    def _check(self) -> None:
        if not self._open():
            raise zenoh.ZError("the session is closed")

    def _settle(self) -> None:
        self._delivery.settle()
        if self.error is not None:
            raise self.error

    def _heard(self, take: Callable[[Any], object]) -> Callable[[Any], object]:
        """Return a callback that ignores its message once the connection was cut off."""
        return lambda item: take(item) if self.error is None else None

    def _take_leave(self, name: str) -> None:
        if name in self._participants:
            del self._participants[name]
            self.simulation.announce(name, alive=False)
            self._settle()

    def _withdraw(self) -> None:
        for declared in self._declared:
            self.simulation.exchange.take_back(declared)
        for name in self._participants:
            self.simulation.announce(name, alive=False)
        self._participants.clear()


def for_client(answer: Any) -> Any:
    """Return an answer as the client receives it, with refusals turned into errors."""
    match answer:
        case Refused(field, value, text):
            return RequestError(text, [{"field": field, "message": text, "value": value}])
        case Granted(accepted=accepted):
            return answer._replace(accepted=tuple(map(for_client, accepted)))
    return answer


class Liveliness:
    """The liveliness tokens of a process, as a session of Zenoh has them."""

    def __init__(self, connection: LocalConnection) -> None:
        self._connection = connection
        self._exchange = connection.simulation.exchange
        self._delivery = connection.simulation.delivery

    def declare_token(self, key: str) -> Declaration:
        """Declare a liveliness token on a key."""
        token = self._connection.declare(Kind.TOKEN, key, lambda _message: None)
        self._delivery.settle()
        return token

    def declare_subscriber(self, key: str, handler: Any, *, history: bool = False) -> Declaration:
        """Declare a subscriber to tokens that come and go; *history* includes the tokens that exist already."""
        declaration = self._connection.declare(Kind.TOKEN_SUBSCRIBER, key, handler)
        for each in self._exchange.matching(Kind.TOKEN, key) if history else ():
            self._delivery.deliver(declaration.call, Sample(str(each.key_expr)))
        self._delivery.settle()
        return declaration

    def get(self, key: str, handler: zenoh.handlers.Callback[Any], **_: object) -> None:
        """Query the tokens that exist."""
        for each in self._exchange.matching(Kind.TOKEN, key):
            self._delivery.deliver(handler.callback, LocalReply(ok=Sample(str(each.key_expr))))
        if handler.drop is not None:
            self._delivery.deliver(lambda drop: drop(), handler.drop)
        self._delivery.settle()


class LocalQuerier:
    """Queries the other connections on one key."""

    def __init__(self, connection: LocalConnection, key: str) -> None:
        self._connection = connection
        self._key = key

    @property
    def matching_status(self) -> SimpleNamespace:
        """The status that says whether another connection has a queryable on the key."""
        found = self._connection.simulation.exchange.matching(Kind.QUERYABLE, self._key)
        return SimpleNamespace(matching=any(map(self._is_others, found)))

    def declare_matching_listener(self, handler: object) -> None:
        """Do nothing: the status is read before each request."""

    def get(self, handler: zenoh.handlers.Callback[Any], **sent: Any) -> None:
        """Send a query to the queryables of the other connections."""
        self._connection.get(self._key, handler, among=self._is_others, **sent)

    def _is_others(self, declaration: Declaration) -> bool:
        return declaration.owner is not self._connection
