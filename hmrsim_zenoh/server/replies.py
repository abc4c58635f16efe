"""Replies to queries: the one answer to a request, one of several where there are wildcards, all to ``execute``."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import zenoh

from hmrsim_zenoh.wire import encoding

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction

_log = logging.getLogger(__name__)


class SharedQuery:
    """A query with several answers; it is dropped after the last one."""

    def __init__(self, query: zenoh.Query) -> None:
        self.query = query
        self.open = 0

    def one_more(self) -> _Share:
        """Return a part of the query for one more answer."""
        self.open += 1
        return _Share(self)


class _Share:
    """One answer's part of a shared query; it has the interface of a query."""

    def __init__(self, shared: SharedQuery) -> None:
        self._shared = shared

    def reply(self, key: str, payload: bytes, *, encoding: str, attachment: bytes | None = None) -> None:
        self._shared.query.reply(key, payload, encoding=encoding, attachment=attachment)

    def reply_err(self, payload: bytes, *, encoding: str) -> None:
        """Drop the error: a query with wildcards gets the values that exist."""

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
        """Send a reply after which there may be others."""
        try:
            self.query.reply(self.key, payload, encoding=mime, attachment=attachment)
        except zenoh.ZError as error:
            _log.debug("replying on %s: %s", self.key, error)

    def reply(self, payload: bytes, mime: str, attachment: bytes | None = None) -> None:
        """Send the one answer, or the last one."""
        try:
            self.send(payload, mime, attachment)
        finally:
            self.query.drop()

    def refuse(self, payload: bytes) -> None:
        """Send the one answer as Zenoh's error reply."""
        try:
            self.query.reply_err(payload, encoding=encoding.JSON)
        except zenoh.ZError as error:
            _log.debug("replying an error on %s: %s", self.key, error)
        finally:
            self.query.drop()


@dataclass(frozen=True, slots=True)
class PendingExecution(PendingReply):
    """A query that has a goal executed: it awaits the acceptance, maybe feedback, and at last the result.

    All its replies have one key, and each has a later timestamp than the one before. So Zenoh's default consolidation
    leaves the last one alone, the result or the rejection, and a querier without consolidation gets each as it is sent.

    Attributes:
        robot: The robot that executes the goal.
        feedback: Whether feedback is awaited.
        timestamp: Returns a timestamp later than all those before.
    """

    query: zenoh.Query
    robot: str = field(kw_only=True)
    feedback: bool = field(kw_only=True)
    timestamp: Callable[[], zenoh.Timestamp] = field(kw_only=True)

    def send(self, payload: bytes, mime: str, attachment: bytes | None = None) -> None:
        """Send one of the replies, with the time."""
        try:
            self.query.reply(self.key, payload, encoding=mime, timestamp=self.timestamp(), attachment=attachment)
        except zenoh.ZError as error:
            _log.debug("replying on %s: %s", self.key, error)
