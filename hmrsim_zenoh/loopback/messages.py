"""What travels between the sessions of a process, with the attributes of Zenoh's classes of these names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Final, Self

import zenoh


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
    """A query at one queryable; it ends when it is dropped, or nobody holds it any more.

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
        """End."""
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
        """Send a reply."""
        attached = None if attachment is None else Payload.of(attachment)
        sample = Sample(str(key), Payload.of(payload), str(encoding), timestamp=timestamp, attachment=attached)
        self._on_reply(Reply(ok=sample))

    def reply_err(self, payload: Any, *, encoding: object = "") -> None:
        """Send an error."""
        self._on_reply(Reply(err=ReplyError(Payload.of(payload), str(encoding))))

    def drop(self) -> None:
        """Send no more replies."""
        on_end, self._on_end = self._on_end, None
        if on_end is not None:
            on_end()
