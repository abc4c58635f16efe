"""The connection over Zenoh: commands are encoded as JSON, and answers decoded."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, TypeVar

import zenoh
from pydantic import BaseModel, Field, ValidationError
from pydantic_core import to_json

from hmrsim.errors import HmrsimError
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.message import Message
from hmrsim.protocol.commands import Advance, CancelGoal, GetResult, SendGoal
from hmrsim.protocol.goal import CancelResponse, GoalEntry, GoalResponse, GoalStatus, ResultResponse
from hmrsim.protocol.outputs import FeedbackSent, GoalChanged, Granted
from hmrsim.protocol.time import HasLeft, Join, Joined, Leave, ReadTime, TimeState
from hmrsim.protocol.topics import Unwatch, Watching
from hmrsim_zenoh.client.conditions import Watched
from hmrsim_zenoh.client.connection import Ask, ReadInfo
from hmrsim_zenoh.errors import ClientClosed, RequestError
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.descriptions import WorldInfo, described
from hmrsim_zenoh.wire.envelopes import (
    CancelGoalResponse,
    Ending,
    FeedbackMessage,
    GoalInfo,
    ResultStatus,
    SendGoalResponse,
    UnreadableError,
    around,
    dump,
    plain,
    read,
    read_often,
    unreadable,
)
from hmrsim_zenoh.wire.keys import Verb

if TYPE_CHECKING:
    from hmrsim_zenoh.client.connection import ActionTarget, Answer, Asked, GoalCommand, Listener
    from hmrsim_zenoh.client.queries import Queries, QueryCall, Reply
    from hmrsim_zenoh.errors import Denied
    from hmrsim_zenoh.wire.keys import Keys

_log = logging.getLogger(__name__)

M = TypeVar("M", bound=BaseModel)

MAX_BYTES: Final = 2**19
"""Bytes of commands that go with one advance: half of what a simulator takes by default."""

_NOT_READ: Final[Any] = None
"""In place of a result that does not matter."""
_STATUSES: Final[Mapping[int | None, GoalStatus]] = MappingProxyType({int(status): status for status in GoalStatus})


class _GrantedEvent(BaseModel):
    """An event of a goal of any client; its kind determines which of *status*, *result* and *feedback* it has."""

    kind: str
    robot: str
    action: str
    goal_id: str
    stamp: Time = Field(default_factory=Time)
    status: int = 0
    result: dict[str, Any] | None = None
    cause: str = ""
    feedback: dict[str, Any] | None = None


class _Accepted(BaseModel):
    """The reply to a command of an advance, whatever it is: each command has some of the fields."""

    accepted: bool = False
    goal_id: str = ""
    stamp: Time = Field(default_factory=Time)
    reason: str | None = None
    error_code: int | None = None
    error_msg: str | None = None
    status: int | None = None
    return_code: int = 0
    goals_canceling: list[GoalInfo] = Field(default_factory=list)
    result: Any = None
    cause: str = ""
    watching: bool = False
    error: Any = None
    details: Any = None


class _Grant(BaseModel):
    """The reply to an advance."""

    epoch: int
    now: float
    reason: str
    accepted: list[_Accepted | None] = Field(default_factory=list)
    events: list[_GrantedEvent] = Field(default_factory=list)
    met: list[str] = Field(default_factory=list)
    over: str = ""


class _Joined(BaseModel):
    epoch: int
    now: float
    goals: int = 0


class _State(BaseModel):
    epoch: int
    now: float
    clock: str


@dataclass(frozen=True)
class _Ports:
    """The keys of an action, and the key and encoding of the request for each kind of command."""

    execute: str
    feedback: str
    requests: Mapping[type, tuple[str, str]]

    @classmethod
    def of(cls, keys: Keys, target: ActionTarget) -> _Ports:
        """Return the ports of one robot's action."""
        action = target.action
        requests = {
            SendGoal: (Verb.SEND_GOAL, f"application/json;{action.ros_type}_SendGoal_Request"),
            CancelGoal: (Verb.CANCEL_GOAL, "application/json;action_msgs/srv/CancelGoal_Request"),
            GetResult: (Verb.GET_RESULT, f"application/json;{action.ros_type}_GetResult_Request"),
        }
        key = partial(keys.action, target.robot, action.name)
        by_command = {command: (key(verb), mime) for command, (verb, mime) in requests.items()}
        return cls(key(Verb.EXECUTE), key(Verb.FEEDBACK), by_command)


class ZenohConnection:
    """A `Connection` to a simulator over Zenoh."""

    ordered = False
    in_process = False

    def __init__(self, queries: Queries, keys: Keys) -> None:
        self._queries = queries
        self._keys = keys
        self._ports: dict[tuple[str, str], _Ports] = {}
        self._listening: list[Callable[[], None]] = []
        # The commands that go with the next advance, as JSON, by the identities of the commands.
        self._encoded: dict[int, tuple[object, bytes]] = {}

    def send(
        self,
        target: ActionTarget,
        command: GoalCommand,
        then: Callable[[Answer], None],
        *,
        timeout: float,
        read: bool = True,
        ended: bool = False,  # noqa: ARG002 - a result is asked for in the same way
    ) -> None:
        """Send a command as a query."""
        key, mime = self._of(target).requests[type(command)]
        decoder: Callable[[bytes], Answer]
        match command:
            case SendGoal():
                payload, decoder = _goal(command), _goal_response
            case CancelGoal(goal_id=goal_id):
                payload = b'{"goal_info":{"goal_id":"%b","stamp":{"sec":0,"nanosec":0}}}' % goal_id.encode()
                decoder = _cancel_response
            case GetResult(goal_id=goal_id):
                payload = b'{"goal_id":"%b"}' % goal_id.encode()
                decoder = partial(_result_response, target, whole=read)
        self._queries.ask(key, payload, partial(_decode, then, decoder), timeout=timeout, mime=mime)

    def execute(
        self,
        target: ActionTarget,
        command: SendGoal,
        *,
        timeout: float,
        on_answer: Callable[[Answer], None],
        on_end: Callable[[], None],
        read: bool = True,
    ) -> None:
        """Send a goal and ask for its result in one query."""
        ports, answered = self._of(target), False

        def take(reply: bytes | RequestError) -> None:
            nonlocal answered
            decoder = partial(_result_response, target, whole=read) if answered else _goal_response
            answered = True
            _decode(on_answer, decoder, reply)

        self._queries.ask_often(
            ports.execute,
            _goal(command),
            timeout=timeout,
            mime=ports.requests[SendGoal][1],
            on_reply=take,
            on_end=on_end,
        )

    def listen(self, target: ActionTarget, listener: Listener) -> None:
        """Subscribe a listener to the feedback of an action; it is called in Zenoh's thread."""
        ports = self._of(target)
        kind: type[Message] = target.action.feedback
        reader = around(FeedbackMessage, kind)

        def take(payload: bytes) -> None:
            if not listener.wanted:
                return
            try:
                sent: FeedbackMessage[Any] = read(reader, payload)
            except UnreadableError as error:
                _log.warning("%s: feedback that can't be read: %s", ports.feedback, error)
                return
            listener.take(sent.goal_id, sent.feedback)

        self._listening.append(self._queries.listen(ports.feedback, take))

    def close(self) -> None:
        """Unsubscribe all listeners; the session stays open."""
        listening, self._listening = self._listening, []
        for end in listening:
            end()

    def call(self, command: Asked, *, timeout: float) -> QueryCall:
        """Send a command for whose answer a thread waits."""
        match command:
            case Join(name, _, token):
                return self._call("join", dump({"name": name, "token": token}), timeout, _joined)
            case Advance():
                return self._call("advance", self._advance(command), timeout, partial(_granted, command))
            case Leave(name):
                return self._call("leave", dump({"participant": name}), timeout, lambda _reply: HasLeft(name))
            case ReadTime():
                return self._call("state", None, timeout, _state)
            case ReadInfo():
                key = self._keys.world("info")
                return self._query(key, None, timeout, partial(described, key, kind=WorldInfo), latest=True)
            case Ask(service, request, response):
                payload = request.model_dump_json(exclude_unset=True).encode()
                decoder = partial(read_often, plain(response))
                return self._query(self._keys.world(service), payload, timeout, decoder, latest=True)

    def token(self) -> str:
        """Return a text that no other connection has."""
        # Zenoh's timestamps contain the session's id and are unique within it.
        return str(self._queries.session.new_timestamp())

    def fitting(self, commands: Sequence[Any]) -> int:
        """Return how many of some commands go with one advance."""
        self._encoded, size = {}, 0
        for number, command in enumerate(commands):
            payload = _command(command)
            size += len(payload)
            if number and size > MAX_BYTES:
                return number
            self._encoded[id(command)] = command, payload
        return len(commands)

    def announce(self, name: str) -> Callable[[], None]:
        """Declare the liveliness token of a participant; return a function that undeclares it."""
        try:
            token = self._queries.session.liveliness().declare_token(self._keys.participant(name))
        except zenoh.ZError:
            raise ClientClosed("the client is closed") from None
        undeclare: Callable[[], None] = token.undeclare
        return undeclare

    def follow(self, on_change: Callable[[bool], None]) -> Callable[[], None]:
        """Report whether the simulator's liveliness token is there, now and whenever that changes."""

        def on_sample(sample: zenoh.Sample) -> None:
            on_change(sample.kind == zenoh.SampleKind.PUT)

        handler = zenoh.handlers.Callback(on_sample, lambda: on_change(False), indirect=False)
        try:
            subscriber = self._queries.session.liveliness().declare_subscriber(
                self._keys.alive(), handler, history=True
            )
        except zenoh.ZError:
            raise ClientClosed("the client is closed") from None
        undeclare: Callable[[], None] = subscriber.undeclare
        return undeclare

    def look(self, on_alive: Callable[[], None], then: Callable[[], None], *, timeout: float) -> None:
        """Query the simulator's liveliness token: call a function if it is there, and then the other."""
        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda _reply: on_alive(), then, indirect=False
        )
        # A closed session has no liveliness.
        with suppress(zenoh.ZError):
            self._queries.session.liveliness().get(self._keys.alive(), handler, timeout=timeout)

    def denial(self, target: ActionTarget, command: GoalCommand) -> Denied | None:
        """Return why a command to an action is denied."""
        return self._queries.denial(self._of(target).requests[type(command)][0])

    def _of(self, target: ActionTarget) -> _Ports:
        ports = self._ports.get((target.robot, target.action.name))
        if ports is None:
            ports = self._ports[target.robot, target.action.name] = _Ports.of(self._keys, target)
        return ports

    def _call(
        self, request: str, payload: bytes | None, timeout: float, decoder: Callable[[bytes], Answer]
    ) -> QueryCall:
        enclave = self._queries.enclave
        member = enclave.member if enclave else None
        by_name = request == "advance" and member is not None and member.role == "controller"
        key = self._keys.world(f"time/{request}/{member.name}" if by_name and member else f"time/{request}")
        return self._query(key, payload, timeout, decoder)

    def _advance(self, command: Advance) -> bytes:
        head = {
            "participant": command.participant,
            "epoch": command.epoch,
            "until": command.until if command.until < math.inf else None,
            "wake": sorted(command.wake),
            "report": sorted(command.report),
        }
        known = self._encoded
        commands = [known[id(each)][1] if id(each) in known else _command(each) for each in command.commands]
        return b'%b,"commands":[%b]}' % (to_json(head)[:-1], b",".join(commands))

    def _query(
        self,
        key: str,
        payload: bytes | None,
        timeout: float,
        decoder: Callable[[bytes], Answer],
        *,
        latest: bool = False,
    ) -> QueryCall:
        def decode(reply: Reply) -> Answer:
            return decoder(reply) if isinstance(reply, bytes) else reply

        return self._queries.call(key, payload, timeout=timeout, latest=latest, decode=decode)


def _decode(then: Callable[[Answer], None], decoder: Callable[[bytes], Answer], reply: Reply) -> None:
    """Pass on a reply as an answer, or why it can't be read."""
    if isinstance(reply, bytes):
        try:
            answer = decoder(reply)
        except HmrsimError as error:
            answer = error
        then(answer)
    else:
        then(reply)


def status_of(number: int | None) -> GoalStatus:
    """Return a status from the wire; UNKNOWN for an invalid one."""
    return _STATUSES.get(number, GoalStatus.UNKNOWN)


def _goal(command: SendGoal) -> bytes:
    goal_id = command.goal_id or ""
    return b'{"goal_id":"%b","goal":%b}' % (goal_id.encode(), _body(command.goal))


def _body(goal: Message | Mapping[str, Any] | None) -> bytes:
    return encoding.message(goal) if isinstance(goal, Message) else to_json(goal)


def _goal_response(reply: bytes) -> GoalResponse:
    sent: SendGoalResponse = read(plain(SendGoalResponse), reply)
    return _response(sent)


def _response(sent: SendGoalResponse | _Accepted) -> GoalResponse:
    return GoalResponse(
        sent.accepted,
        sent.goal_id,
        sent.stamp.to_nanoseconds(),
        sent.reason or "",
        sent.error_code or 0,
        sent.error_msg or "",
        None if sent.status is None else status_of(sent.status),
    )


def _cancel_response(reply: bytes) -> CancelResponse:
    sent: CancelGoalResponse = read(plain(CancelGoalResponse), reply)
    return _canceling(sent)


def _canceling(sent: CancelGoalResponse | _Accepted) -> CancelResponse:
    goals = sent.goals_canceling
    entries = (GoalEntry(each.goal_id, each.stamp.to_nanoseconds(), GoalStatus.CANCELING) for each in goals)
    return CancelResponse(sent.return_code, tuple(entries))


def _result_response(target: ActionTarget, reply: bytes, *, whole: bool) -> ResultResponse:
    if not whole:
        status = status_of(read(plain(ResultStatus), reply).status)
        if status is GoalStatus.SUCCEEDED:
            return ResultResponse(status, _NOT_READ)
    kind: type[Message] = target.action.result
    sent: Ending[Any] = read(around(Ending, kind), reply)
    return ResultResponse(status_of(sent.status), sent.result, sent.cause)


def _joined(reply: bytes) -> Joined:
    sent = _read(_Joined, reply)
    return Joined("", sent.epoch, sent.now, sent.goals)


def _state(reply: bytes) -> TimeState:
    sent = _read(_State, reply)
    return TimeState(
        sent.now, sent.clock, 0.0, paused=False, epoch=sent.epoch, participants=(), waiting_for=(), lag=0.0
    )


def _granted(command: Advance, reply: bytes) -> Granted:
    sent = _read(_Grant, reply)
    accepted = tuple(map(_accepted, command.commands, sent.accepted))
    events = tuple(map(_event, sent.events))
    return Granted(sent.epoch, sent.now, sent.reason, accepted, events, tuple(sent.met), sent.over)


def _accepted(command: Any, sent: _Accepted | None) -> Answer:
    if sent is None:
        return None
    if sent.error is not None:
        return RequestError(str(sent.error), [each for each in sent.details or () if isinstance(each, dict)])
    match command:
        case SendGoal():
            return _response(sent)
        case CancelGoal():
            return _canceling(sent)
        case GetResult():
            return ResultResponse(status_of(sent.status), sent.result, sent.cause)
    return Watching(sent.watching)


def _event(sent: _GrantedEvent) -> tuple[str, int, GoalChanged | FeedbackSent]:
    stamp = sent.stamp.to_nanoseconds()
    if sent.kind == "feedback":
        return sent.kind, stamp, FeedbackSent(sent.robot, sent.action, sent.goal_id, sent.feedback or {})
    # The client that waits for the result knows its type, and makes it a message.
    result: Any = sent.result
    status = status_of(sent.status)
    change = GoalChanged(stamp, sent.robot, sent.action, sent.goal_id, status, None, result, sent.cause)
    return sent.kind, stamp, change


def _read(kind: type[M], payload: bytes) -> M:
    try:
        return kind.model_validate_json(payload)
    except ValidationError as error:
        raise unreadable(error) from None


def _command(command: Any) -> bytes:
    """Return a command of an advance."""
    match command:
        case Watched(name, condition):
            return dump({"watch": name, "key": condition.key, "when": [list(each) for each in condition.when]})
        case Unwatch(name):
            return dump({"unwatch": name})
    head = b'{"robot":"%b","action":"%b",' % (command.robot.encode(), command.action.encode())
    match command:
        case SendGoal():
            return head + _goal(command)[1:]
        case CancelGoal():
            return head + b'"cancel":"%b"}' % command.goal_id.encode()
    return head + b'"result":"%b"}' % command.goal_id.encode()
