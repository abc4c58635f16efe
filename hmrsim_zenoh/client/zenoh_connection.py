"""The connection over Zenoh: commands are encoded as JSON, and answers decoded."""

from __future__ import annotations

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import partial
from queue import Empty, SimpleQueue
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, TypeVar

import zenoh
import zenoh.ext
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
from hmrsim_zenoh.client.connection import Ask, Connection, Read, ReadInfo, Watched, body_of, take_within
from hmrsim_zenoh.client.worker import Worker
from hmrsim_zenoh.errors import Denied, RequestError
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.descriptions import WorldInfo, described
from hmrsim_zenoh.wire.envelopes import (
    CancelGoalResponse,
    Ending,
    FeedbackMessage,
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
from hmrsim_zenoh.wire.session import unless_closed

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim_zenoh.client.connection import ActionTarget, Answer, Asked, GoalCommand, Reply
    from hmrsim_zenoh.wire.enclave import Enclave
    from hmrsim_zenoh.wire.keys import Keys

M = TypeVar("M", bound=BaseModel)

_log = logging.getLogger(__name__)

MAX_BYTES: Final = 2**19
"""Bytes of commands that go with one advance: half of what a simulator takes by default."""

_VERBS: Final[Mapping[type, Verb]] = MappingProxyType(
    {SendGoal: Verb.SEND_GOAL, CancelGoal: Verb.CANCEL_GOAL, GetResult: Verb.GET_RESULT}
)
_NOT_READ: Final[Any] = None
"""In place of a result that does not matter."""
_STATUSES: Final[Mapping[int, GoalStatus]] = MappingProxyType({int(status): status for status in GoalStatus})


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


class _Time(BaseModel):
    """The reply to a request about time: each has the epoch and the time, and some of the other fields."""

    epoch: int
    now: float
    goals: int = 0
    clock: str = ""
    reason: str = ""
    accepted: list[dict[str, Any] | None] = Field(default_factory=list)
    events: list[_GrantedEvent] = Field(default_factory=list)
    met: list[str] = Field(default_factory=list)
    over: str = ""


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

    def __init__(self, decode: Callable[[bytes], Answer], silence: Callable[[], RequestError | None]) -> None:
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
            self.answer = self._silence() if body is None else self._decode(body) if isinstance(body, bytes) else body
        return True


class ZenohConnection(Connection):
    """The connection to a simulator over Zenoh; its worker runs what must not run in Zenoh's threads."""

    def __init__(self, session: zenoh.Session, keys: Keys, enclave: Enclave | None = None) -> None:
        self.enclave = enclave
        # Not Session.is_closed(): it waits for Zenoh's lock with the GIL held, and the lock's holder may want the GIL.
        self.broken = False
        self._session = session
        self._keys = keys
        self._worker = Worker("hmrsim client")
        self._known: dict[tuple[ActionTarget, Verb], str] = {}
        self._listening: list[Callable[[], object]] = []
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
        **_options: bool,
    ) -> None:
        """Send a command as a query."""
        decoder: Callable[[bytes], Answer]
        kind = f"{target.action.ros_type}_GetResult_Request"
        match command:
            case SendGoal():
                kind, payload, decoder = _goal_type(target), _goal(command), _goal_response
            case CancelGoal(goal_id=goal_id):
                payload = b'{"goal_info":{"goal_id":"%b","stamp":{"sec":0,"nanosec":0}}}' % goal_id.encode()
                kind, decoder = "action_msgs/srv/CancelGoal_Request", _cancel_response
            case GetResult(goal_id=goal_id):
                payload = b'{"goal_id":"%b"}' % goal_id.encode()
                decoder = partial(_result_response, target, whole=read)
        key = self._key(target, _VERBS[type(command)])
        self._ask(key, payload, partial(_decode, then, decoder), timeout=timeout, kind=kind)

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
        """Send a goal and ask for its result in one query, whose replies are taken in Zenoh's thread."""
        answered = False

        def take(reply: zenoh.Reply) -> None:
            nonlocal answered
            # A timeout is no reply, just the end.
            if (body := body_of(reply)) is not None:
                decoder = partial(_result_response, target, whole=read) if answered else _goal_response
                answered = True
                _decode(on_answer, decoder, body)

        handler = zenoh.handlers.Callback(take, on_end, indirect=False)
        self._get(self._key(target, Verb.EXECUTE), _goal(command), handler, timeout, kind=_goal_type(target))

    def listen(self, target: ActionTarget) -> None:
        """Subscribe to the feedback of an action; its target is called in Zenoh's thread."""
        kind: type[Message] = target.action.feedback
        reader = around(FeedbackMessage, kind)

        def take(key: str, payload: bytes) -> None:
            if not target.wanted:
                return
            try:
                sent: FeedbackMessage[Any] = read(reader, payload)
            except UnreadableError as error:
                _log.warning("%s: feedback that can't be read: %s", key, error)
                return
            target.take(sent.goal_id, sent.feedback)

        self._listening.append(self.subscribe(self._key(target, Verb.FEEDBACK), take))

    def unlisten(self) -> None:
        """Unsubscribe from all feedback; the session stays open."""
        listening, self._listening = self._listening, []
        for end in listening:
            end()

    def subscribe(self, key: str, take: Callable[[str, bytes], None], *, history: bool = False) -> Callable[[], object]:
        """Call a function in Zenoh's thread with the key and payload of each sample; return a function to end that."""
        handler: zenoh.handlers.Callback[zenoh.Sample] = zenoh.handlers.Callback(
            lambda sample: take(str(sample.key_expr), sample.payload.to_bytes()), indirect=False
        )
        with unless_closed():
            if not history:
                return self._session.declare_subscriber(key, handler).undeclare
            late = zenoh.ext.HistoryConfig(detect_late_publishers=True)
            subscriber = zenoh.ext.declare_advanced_subscriber(self._session, key, handler, history=late)
            undeclare: Callable[[], object] = subscriber.undeclare
            return undeclare

    def call(self, command: Asked, *, timeout: float) -> QueryCall:
        """Send a command for whose answer a thread waits."""
        payload: bytes | None = None
        decoder: Callable[[bytes], Answer]
        match command:
            case Join(name, _, token):
                key, payload, decoder = "time/join", dump({"name": name, "token": token}), _joined
            case Advance():
                member = self.enclave.member if self.enclave else None
                own = f"/{member.name}" if member is not None and member.role == "controller" else ""
                key, payload, decoder = f"time/advance{own}", self._advance(command), partial(_granted, command)
            case Leave(name):
                key, payload, decoder = "time/leave", dump({"participant": name}), lambda _reply: HasLeft(name)
            case ReadTime():
                key, decoder = "time/state", _state
            case ReadInfo():
                key, decoder = "info", partial(described, self._keys.world("info"), kind=WorldInfo)
            case Ask(key, request, response):
                payload = request.model_dump_json(exclude_unset=True).encode()
                decoder = partial(read_often, plain(response))
            case Read(key, payload):
                decoder = bytes
        key = key if isinstance(command, Read) else self._keys.world(key)
        call = QueryCall(decoder, partial(self._denial, key))
        self._get(key, payload, call.handler, timeout, latest=isinstance(command, (ReadInfo, Ask, Read)))
        return call

    def ask(self, request: Read, then: Callable[[Reply], None], *, timeout: float) -> None:
        """Send a query; *then* receives the answer, once: a reply in Zenoh's thread, its absence in the worker's."""
        self._ask(request.key, request.payload, then, timeout=timeout, latest=True)

    def worker(self) -> Worker:
        """Return what runs deferred calls."""
        return self._worker

    def token(self) -> str:
        """Return a text that no other connection has."""
        # Zenoh's timestamps contain the session's id and are unique within it.
        return str(self._session.new_timestamp())

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
        with unless_closed():
            undeclare: Callable[[], None] = (
                self._session.liveliness().declare_token(self._keys.participant(name)).undeclare
            )
            return undeclare

    def follow(self, on_change: Callable[[bool], None]) -> Callable[[], object]:
        """Report whether the simulator's liveliness token is there, now and whenever that changes."""

        def on_sample(sample: zenoh.Sample) -> None:
            on_change(sample.kind == zenoh.SampleKind.PUT)

        handler = zenoh.handlers.Callback(on_sample, lambda: on_change(False), indirect=False)
        with unless_closed():
            liveliness = self._session.liveliness()
            return liveliness.declare_subscriber(self._keys.alive(), handler, history=True).undeclare

    def look(self, on_alive: Callable[[], None], then: Callable[[], None], *, timeout: float) -> None:
        """Query the simulator's liveliness token: call a function if it is there, and then the other."""
        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda _reply: on_alive(), then, indirect=False
        )
        # A closed session has no liveliness.
        with suppress(zenoh.ZError):
            self._session.liveliness().get(self._keys.alive(), handler, timeout=timeout)

    def denial(self, target: ActionTarget, command: GoalCommand) -> Denied | None:
        """Return why a command to an action is denied."""
        return self._denial(self._key(target, _VERBS[type(command)]))

    def _denial(self, key: str) -> Denied | None:
        """Return why a query that nothing answers is denied; None if access control allows it, or there is none."""
        if self.enclave is None:
            return None
        text = self.enclave.access_control.denial(self.enclave.name, key)
        return Denied(text) if text else None

    def _key(self, target: ActionTarget, verb: Verb) -> str:
        key = self._known.get((target, verb))
        if key is None:
            key = self._known[target, verb] = self._keys.action(target.robot, target.action.name, verb)
        return key

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

    def _ask(
        self,
        key: str,
        payload: bytes | None,
        then: Callable[[Reply], None],
        *,
        timeout: float,
        kind: str = "",
        latest: bool = False,
    ) -> None:
        """Send a query whose answer is its first reply, or the *latest* of several, which takes a little longer."""
        open_ = True

        def answer(body: Reply) -> None:
            nonlocal open_
            if not open_:
                return
            open_ = False
            if body is None:
                # Zenoh may end a query with its lock held: a call on the session in this callback would deadlock.
                self._worker.after(0.0, lambda: then(self._denial(key)))
            else:
                then(body)

        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            lambda reply: answer(body_of(reply)), lambda: answer(None), indirect=False
        )
        self._get(key, payload, handler, timeout, kind=kind, latest=latest)

    def _get(
        self,
        key: str,
        payload: bytes | None,
        handler: zenoh.handlers.Callback[zenoh.Reply],
        timeout: float,
        *,
        kind: str = "",
        latest: bool = False,
    ) -> None:
        # For the latest reply Zenoh waits for the end of the query, which is a separate message.
        mode = zenoh.ConsolidationMode.AUTO if latest else zenoh.ConsolidationMode.NONE
        mime = f"{encoding.JSON};{kind}" if kind else encoding.JSON
        try:
            self._session.get(key, handler, payload=payload, encoding=mime, timeout=timeout, consolidation=mode)
        except zenoh.ZError:
            # The keys are valid, so the session is at fault.
            self.broken = True
            if handler.drop is not None:
                handler.drop()


def prepare_messages(action: AnyAction) -> None:
    """Build the writer and the readers of the messages of an action, which takes a moment upon first use."""
    result: type[Message] = action.result
    feedback: type[Message] = action.feedback
    encoding.message(action.goal())
    plain(SendGoalResponse)
    around(Ending, result)
    around(FeedbackMessage, feedback)


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


def status_of(number: object) -> GoalStatus:
    """Return a status from the wire; UNKNOWN for an invalid one."""
    return _STATUSES.get(number, GoalStatus.UNKNOWN) if isinstance(number, int) else GoalStatus.UNKNOWN


def _goal_type(target: ActionTarget) -> str:
    return f"{target.action.ros_type}_SendGoal_Request"


def _goal(command: SendGoal) -> bytes:
    goal, goal_id = command.goal, command.goal_id or ""
    body = encoding.message(goal) if isinstance(goal, Message) else to_json(goal)
    return b'{"goal_id":"%b","goal":%b}' % (goal_id.encode(), body)


def _goal_response(reply: bytes | Mapping[str, Any]) -> GoalResponse:
    sent = _read(SendGoalResponse, reply)
    return GoalResponse(
        sent.accepted,
        sent.goal_id,
        sent.stamp.to_nanoseconds(),
        sent.reason or "",
        sent.error_code or 0,
        sent.error_msg or "",
        None if sent.status is None else status_of(sent.status),
    )


def _cancel_response(reply: bytes | Mapping[str, Any]) -> CancelResponse:
    sent = _read(CancelGoalResponse, reply)
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
    sent = _read(_Time, reply)
    return Joined("", sent.epoch, sent.now, sent.goals)


def _state(reply: bytes) -> TimeState:
    sent = _read(_Time, reply)
    return TimeState(
        sent.now, sent.clock, 0.0, paused=False, epoch=sent.epoch, participants=(), waiting_for=(), lag=0.0
    )


def _granted(command: Advance, reply: bytes) -> Granted:
    sent = _read(_Time, reply)
    accepted = tuple(map(_accepted, command.commands, sent.accepted))
    events = tuple(map(_event, sent.events))
    return Granted(sent.epoch, sent.now, sent.reason, accepted, events, tuple(sent.met), sent.over)


def _accepted(command: Any, sent: Mapping[str, Any] | None) -> Answer:
    if sent is None:
        return None
    if (error := sent.get("error")) is not None:
        details = sent.get("details")
        details = details if isinstance(details, list) else ()
        return RequestError(str(error), [each for each in details if isinstance(each, dict)])
    match command:
        case SendGoal():
            return _goal_response(sent)
        case CancelGoal():
            return _cancel_response(sent)
        case GetResult():
            result: Any = sent.get("result")
            return ResultResponse(status_of(sent.get("status")), result, str(sent.get("cause", "")))
    return Watching(bool(sent.get("watching")))


def _event(sent: _GrantedEvent) -> tuple[str, int, GoalChanged | FeedbackSent]:
    stamp = sent.stamp.to_nanoseconds()
    if sent.kind == "feedback":
        return sent.kind, stamp, FeedbackSent(sent.robot, sent.action, sent.goal_id, sent.feedback or {})
    # The client that waits for the result knows its type, and makes it a message.
    result: Any = sent.result
    status = status_of(sent.status)
    change = GoalChanged(stamp, sent.robot, sent.action, sent.goal_id, status, None, result, sent.cause)
    return sent.kind, stamp, change


def _read(kind: type[M], reply: bytes | Mapping[str, Any]) -> M:
    """Return the model in a reply, or in a part of one, which has been read from JSON already."""
    model: M
    try:
        model = read(plain(kind), reply) if isinstance(reply, bytes) else plain(kind).validate_python(reply)
    except ValidationError as error:
        raise unreadable(error) from None
    return model


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
