"""Replies to queries: the queries that await them, their answers as JSON, and refusals."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import starmap
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import zenoh
from pydantic_core import to_json

from hmrsim.actions import registry as all_actions
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.commands import CallService, SendGoal
from hmrsim.protocol.goal import CancelResponse, GoalResponse, Refused, ResultResponse
from hmrsim.protocol.outputs import FeedbackSent, Granted, Sampled, StatusChanged
from hmrsim.protocol.time import HasLeft, Joined, TimeState
from hmrsim.protocol.topics import Watching
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.envelopes import dump

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.protocol.commands import AnyCommand, Inbox

_log = logging.getLogger(__name__)

_MIMES: Final[Mapping[type, str]] = MappingProxyType(
    {
        Granted: f"{encoding.JSON};hmrsim/Granted",
        Joined: f"{encoding.JSON};hmrsim/Joined",
        HasLeft: f"{encoding.JSON};hmrsim/Left",
        TimeState: f"{encoding.JSON};hmrsim/TimeState",
        CancelResponse: encoding.CANCEL_RESPONSE,
        StatusChanged: encoding.STATUS,
    }
)
_PARTS: Final[Mapping[type, str]] = MappingProxyType(
    {GoalResponse: "SendGoal_Response", ResultResponse: "GetResult_Response"}
)
"""The part of an action's type that each type of answer is."""

ENDED: Final = "the simulation has ended"
"""The reason for refusing a request that comes after the end."""


class SharedQuery:
    """A query that gets several answers and is dropped after the last one; it has the interface of a query."""

    def __init__(self, query: zenoh.Query, answers: int) -> None:
        self._query = query
        self._open = answers

    def reply(self, key: str, payload: bytes, *, encoding: str, attachment: bytes | None = None) -> None:
        """Send one of the answers."""
        self._query.reply(key, payload, encoding=encoding, attachment=attachment)

    def reply_err(self, payload: bytes, *, encoding: str) -> None:
        """Ignore the error: a query with wildcards gets the values that exist."""

    def drop(self) -> None:
        """Count an answer as sent, and drop the query after the last one."""
        self._open -= 1
        if not self._open:
            self._query.drop()


@dataclass(slots=True, eq=False)
class PendingReply:
    """A query that awaits its answer.

    Attributes:
        query: Zenoh's query, or one that is shared with other answers.
        key: The concrete key of the reply.
        action: The action that the query is for, if any.
    """

    query: zenoh.Query | SharedQuery
    key: str
    action: AnyAction | None = None

    def reply(self, payload: bytes, mime: str, attachment: bytes | None = None) -> None:
        """Send the only or last reply."""
        try:
            self.query.reply(self.key, payload, encoding=mime, attachment=attachment)
        except zenoh.ZError as error:
            _log.debug("replying on %s: %s", self.key, error)
        finally:
            self.query.drop()

    def refuse(self, payload: bytes) -> None:
        """Send an error as the only reply."""
        try:
            self.query.reply_err(payload, encoding=encoding.JSON)
        except zenoh.ZError as error:
            _log.debug("replying an error on %s: %s", self.key, error)
        finally:
            self.query.drop()


@dataclass(slots=True, eq=False)
class PendingExecution(PendingReply):
    """A query that executes a goal: it awaits the acceptance, feedback on request, and finally the result.

    All its replies have the same key and increasing timestamps. So Zenoh's default consolidation keeps only the last
    reply, the result or the rejection; a querier without consolidation gets each reply as it is sent.

    Attributes:
        robot: The robot that executes the goal.
        feedback: Whether the query awaits feedback.
        timestamp: Returns a timestamp later than all earlier ones.
    """

    query: zenoh.Query
    robot: str = field(kw_only=True)
    feedback: bool = field(kw_only=True)
    timestamp: Callable[[], zenoh.Timestamp] = field(kw_only=True)

    def send(self, payload: bytes, mime: str, attachment: bytes | None = None) -> None:
        """Send a reply that others may follow, with a timestamp."""
        try:
            self.query.reply(self.key, payload, encoding=mime, timestamp=self.timestamp(), attachment=attachment)
        except zenoh.ZError as error:
            _log.debug("replying on %s: %s", self.key, error)

    def reply(self, payload: bytes, mime: str, attachment: bytes | None = None) -> None:
        """Send the last reply, and drop the query."""
        try:
            self.send(payload, mime, attachment)
        finally:
            self.query.drop()


def encoded(answer: Any, action: AnyAction | None = None) -> tuple[bytes, str, bytes | None]:
    """Return an answer as JSON, its encoding, and the attachment of the reply.

    Args:
        answer: An answer to a command, except `Refused`.
        action: The action that the command was for, if any.
    """
    if isinstance(answer, Sampled):
        answer = answer.message
    kind, cause = type(answer), None
    if kind in _MIMES:
        mime = _MIMES[kind]
    elif kind in _PARTS:
        mime = encoding.of_action(action, _PARTS[kind]) if action else encoding.JSON
        cause = answer.cause.encode() or None if kind is ResultResponse else None
    else:
        return encoding.message(answer), encoding.of_message(answer), None
    return _WRITERS[kind](answer), mime, cause


def _granted(answer: Granted) -> bytes:
    accepted = b",".join([_WRITERS[type(response)](response) for response in answer.accepted])
    events = b",".join(starmap(_event, answer.events))
    head = f'{{"epoch":{answer.epoch},"now":{answer.now},"reason":"{answer.reason}"'
    met = b',"met":%b' % to_json(answer.met) if answer.met else b""
    over = b',"over":%b' % to_json(answer.over) if answer.over else b""
    return b'%b,"accepted":[%b],"events":[%b]%b%b}' % (head.encode(), accepted, events, met, over)


def _fields(answer: NamedTuple) -> bytes:
    """Return the JSON of an answer whose fields are those of its message."""
    return dump(answer._asdict())


_WRITERS: Final[Mapping[type, Callable[[Any], bytes]]] = MappingProxyType(
    {
        Granted: _granted,
        Joined: _fields,
        HasLeft: _fields,
        TimeState: _fields,
        StatusChanged: encoding.status_array,
        GoalResponse: encoding.goal_response,
        CancelResponse: encoding.cancel_response,
        ResultResponse: encoding.result_response,
        Watching: lambda answer: b'{"watching":true}' if answer.watching else b'{"watching":false}',
        Refused: lambda answer: encoding.error(answer.message, answer.field, answer.value),
        bytes: bytes,
        type(None): lambda _answer: b"null",
    }
)
"""The functions that encode an answer, or the response to a command of an advance, by its type."""


def _event(kind: str, at: int, event: Any) -> bytes:
    sec, nanosec = divmod(at, NANOSECONDS)
    head = (
        f'{{"stamp":{{"sec":{sec},"nanosec":{nanosec}}},"kind":"{kind}","robot":"{event.robot}",'
        f'"action":"{event.action}","goal_id":"{event.goal_id}",'
    ).encode()
    if isinstance(event, FeedbackSent):
        return b'%b"feedback":%b}' % (head, encoding.feedback_body(event.feedback))
    if kind == "result" and event.result is not None:
        cause, result = encoding.cause(event.cause), encoding.message(event.result)
        return b'%b"status":%d,%b"result":%b}' % (head, event.status, cause, result)
    return b'%b"status":%d}' % (head, event.status)


def not_served(action: str, goal_id: str | None, reason: str, text: str) -> GoalResponse:
    """Return the reply to a goal that does not reach the simulation."""
    known = all_actions().get(action)
    code = known.codes.rejected if known else 1
    return GoalResponse(False, goal_id or "", stamp=1, reason=reason, error_code=code, error_msg=text)


def after_the_end(command: object) -> GoalResponse | Refused:
    """Return the answer to a command that comes after the end."""
    if isinstance(command, SendGoal):
        return not_served(command.action, command.goal_id, "not_ready", ENDED)
    return Refused("", None, ENDED)


def finish(inbox: Inbox, submit: Callable[[AnyCommand], None], answer: Callable[[Any, Any], None]) -> None:
    """Close an inbox after the end of the simulation, and answer all commands that still wait there.

    Args:
        inbox: The inbox.
        submit: Processes all commands except new goals and services.
        answer: Sends the answer to a new goal or a service call.
    """
    inbox.close()
    while (command := inbox.poll()) is not None:
        if isinstance(command, (SendGoal, CallService)):
            answer(command.reply_to, after_the_end(command))
        else:
            submit(command)
