"""Replies to queries: the queries that await them, and the JSON answers to time requests."""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import starmap
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

import zenoh
from pydantic_core import to_json

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.goal import CancelResponse, GoalResponse, Refused, ResultResponse
from hmrsim.protocol.outputs import FeedbackSent, Granted, TimeAnswer
from hmrsim.protocol.time import HasLeft, Joined, TimeState
from hmrsim.protocol.topics import Watching
from hmrsim_zenoh.wire import encoding
from hmrsim_zenoh.wire.envelopes import dump

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction

_log = logging.getLogger(__name__)

JOINED: Final = f"{encoding.JSON};hmrsim/Joined"
GRANTED: Final = f"{encoding.JSON};hmrsim/Granted"
LEFT: Final = f"{encoding.JSON};hmrsim/Left"
TIME_STATE: Final = f"{encoding.JSON};hmrsim/TimeState"


class SharedQuery:
    """A query with several answers, which is dropped after the last one."""

    def __init__(self, query: zenoh.Query) -> None:
        self.query = query
        self.open = 0

    def add_share(self) -> _Share:
        """Return the part of the query for one more answer."""
        self.open += 1
        return _Share(self)


class _Share:
    """The part of a shared query for one answer, with the interface of a query."""

    def __init__(self, shared: SharedQuery) -> None:
        self._shared = shared

    def reply(self, key: str, payload: bytes, *, encoding: str, attachment: bytes | None = None) -> None:
        self._shared.query.reply(key, payload, encoding=encoding, attachment=attachment)

    def reply_err(self, payload: bytes, *, encoding: str) -> None:
        """Ignore the error: a query with wildcards gets the values that exist."""

    def drop(self) -> None:
        self._shared.open -= 1
        if not self._shared.open:
            self._shared.query.drop()


@dataclass(frozen=True, slots=True)
class PendingReply:
    """A query that awaits its answer.

    Attributes:
        query: Zenoh's query, or a part of one with several answers.
        key: The concrete key of the reply.
        action: The action that the query is for, if any.
    """

    query: zenoh.Query | _Share
    key: str
    action: AnyAction | None = None

    def send(self, payload: bytes, mime: str, attachment: bytes | None = None) -> None:
        """Send a reply; others may follow."""
        try:
            self.query.reply(self.key, payload, encoding=mime, attachment=attachment)
        except zenoh.ZError as error:
            _log.debug("replying on %s: %s", self.key, error)

    def reply(self, payload: bytes, mime: str, attachment: bytes | None = None) -> None:
        """Send the only or last reply."""
        try:
            self.send(payload, mime, attachment)
        finally:
            self.query.drop()

    def refuse(self, payload: bytes) -> None:
        """Send the only reply, an error reply."""
        try:
            self.query.reply_err(payload, encoding=encoding.JSON)
        except zenoh.ZError as error:
            _log.debug("replying an error on %s: %s", self.key, error)
        finally:
            self.query.drop()


@dataclass(frozen=True, slots=True)
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
        """Send a reply with a timestamp; others may follow."""
        try:
            self.query.reply(self.key, payload, encoding=mime, timestamp=self.timestamp(), attachment=attachment)
        except zenoh.ZError as error:
            _log.debug("replying on %s: %s", self.key, error)


def encoded(answer: TimeAnswer) -> tuple[bytes, str]:
    """Return an answer to a time request as JSON, and its encoding."""
    match answer:
        case Granted():
            return _granted(answer), GRANTED
        case Joined(participant, epoch, now, goals):
            fields = {"participant": participant, "epoch": epoch, "now": now, "goals": goals}
            return dump(fields), JOINED
        case HasLeft(participant):
            return dump({"participant": participant}), LEFT
        case TimeState():
            return state(answer), TIME_STATE


def state(answer: TimeState) -> bytes:
    """Return the state of the clock as JSON."""
    return dump(answer._asdict())


def _granted(answer: Granted) -> bytes:
    accepted = b",".join([_ENCODERS[type(response)](response) for response in answer.accepted])
    events = b",".join(starmap(_event, answer.events))
    head = f'{{"epoch":{answer.epoch},"now":{answer.now},"reason":"{answer.reason}"'
    met = b',"met":%b' % to_json(answer.met) if answer.met else b""
    over = b',"over":%b' % to_json(answer.over) if answer.over else b""
    return b'%b,"accepted":[%b],"events":[%b]%b%b}' % (head.encode(), accepted, events, met, over)


_ENCODERS: Final[Mapping[type, Callable[[Any], bytes]]] = MappingProxyType(
    {
        GoalResponse: encoding.goal_response,
        CancelResponse: encoding.cancel_response,
        ResultResponse: encoding.result_response,
        Watching: lambda answer: b'{"watching":true}' if answer.watching else b'{"watching":false}',
        Refused: lambda answer: encoding.error(answer.message, answer.field, answer.value),
        bytes: bytes,
        type(None): lambda _answer: b"null",
    }
)
"""The functions that encode the response to a command, by its type."""


def _event(kind: str, at: int, event: Any) -> bytes:
    sec, nanosec = divmod(at, NANOSECONDS)
    head = (
        f'{{"stamp":{{"sec":{sec},"nanosec":{nanosec}}},"kind":"{kind}","robot":"{event.robot}",'
        f'"action":"{event.action}","goal_id":"{event.goal_id}",'
    ).encode()
    if isinstance(event, FeedbackSent):
        return b'%b"feedback":%b}' % (head, encoding.feedback_body(event.feedback))
    if kind == "result" and event.result is not None:
        cause = encoding.cause(event.cause)
        return b'%b"status":%d,%b"result":%b}' % (head, event.status, cause, encoding.message(event.result))
    return b'%b"status":%d}' % (head, event.status)
