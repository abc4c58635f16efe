"""Injected faults of communication: answers that get lost, and requests that arrive twice."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, cast

if TYPE_CHECKING:
    import zenoh


_FIELDS: Final = ("key_expr", "selector", "parameters", "payload", "encoding", "attachment")
"""The attributes of a query that can be read."""


class Losses:
    """Decides which answers are lost and which requests arrive twice; none by default.

    Queries without a payload, which are readings and wakeups, are exempt: a client simply repeats them.

    Attributes:
        watching: Whether answers to requests that come now may get lost.
        active: Whether any request or answer may ever have been lost or repeated.
    """

    def __init__(self) -> None:
        self.watching = self.active = False
        self._answers = 0
        self._requests = 0

    def watch(self) -> None:
        """Prepare to lose answers to requests that come from now on."""
        self.watching = self.active = True

    def lose_answers(self, count: int) -> None:
        """Lose the next answers, including those to requests that have come since `watch`."""
        self._answers += count

    def repeat_requests(self, count: int) -> None:
        """Deliver each of the next requests twice; the client gets the answer to the first one."""
        self._requests += count
        self.active = True

    def arrivals(self, query: zenoh.Query) -> tuple[zenoh.Query, ...]:
        """Return a query as it arrives: once, or twice."""
        if not self.active:
            return (query,)
        payload = query.payload
        if payload is None or not payload.to_bytes():
            return (query,)
        watched = cast("zenoh.Query", _Watched(query, self)) if self.watching else query
        return (watched, cast("zenoh.Query", _Repeated(query))) if self.comes_twice() else (watched,)

    def comes_twice(self) -> bool:
        """Return whether the current request arrives twice, and count it."""
        twice = self._requests > 0
        self._requests -= twice
        return twice

    def lost(self) -> bool:
        """Return whether the current answer is lost, and count it."""
        lost = self._answers > 0
        self._answers -= lost
        return lost


class _Watched:
    """A query whose answers may get lost; it has the interface of a query."""

    def __init__(self, query: zenoh.Query, losses: Losses) -> None:
        self._query = query
        self._losses = losses

    def __getattr__(self, name: str) -> Any:
        return getattr(self._query, name)

    def reply(self, *arguments: Any, **options: Any) -> None:
        if not self._losses.lost():
            self._query.reply(*arguments, **options)

    def reply_err(self, *arguments: Any, **options: Any) -> None:
        if not self._losses.lost():
            self._query.reply_err(*arguments, **options)


class _Repeated:
    """The second arrival of a query, whose answers are dropped: the answer to the first one has ended the query."""

    def __init__(self, query: zenoh.Query) -> None:
        # A query that has ended can't be read.
        self._read = {name: getattr(query, name, None) for name in _FIELDS}

    def __getattr__(self, name: str) -> Any:
        if name not in _FIELDS:
            raise AttributeError(name)
        return self._read[name]

    def reply(self, *arguments: Any, **options: Any) -> None:
        """Drop the answer to a repeated request."""

    def reply_err(self, *arguments: Any, **options: Any) -> None:
        """Drop the answer to a repeated request."""

    def drop(self) -> None:
        """Do nothing: the first answer ends the query."""
