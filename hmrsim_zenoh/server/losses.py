"""Losses on the way between clients and the simulation, on purpose: answers that get lost, requests that come twice."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, cast

if TYPE_CHECKING:
    import zenoh


_FIELDS: Final = ("key_expr", "selector", "parameters", "payload", "encoding", "attachment")
"""What can be read of a query."""


class Losses:
    """What of requests and answers is lost, or comes twice: nothing, unless that is asked for.

    Readings and wakeups are left alone, which are queries with an empty payload or none: they are repeated without a
    thought.

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
        """Lose the next answers, also to requests that have come since `watch`."""
        self._answers += count

    def repeat_requests(self, count: int) -> None:
        """Let the next requests come twice; only the answers to the first of both arrive."""
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
        """Return whether a request that comes now comes twice, and count it."""
        twice = self._requests > 0
        self._requests -= twice
        return twice

    def lost(self) -> bool:
        """Return whether an answer that is sent now is lost, and count it."""
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
    """A query that has come again: nobody hears the answers to it, as with those to the first one it has ended."""

    def __init__(self, query: zenoh.Query) -> None:
        # Nothing can be read of the first one once that has ended.
        self._read = {name: getattr(query, name, None) for name in _FIELDS}

    def __getattr__(self, name: str) -> Any:
        if name not in _FIELDS:
            raise AttributeError(name)
        return self._read[name]

    def reply(self, *arguments: Any, **options: Any) -> None:
        """Send nothing."""

    def reply_err(self, *arguments: Any, **options: Any) -> None:
        """Send nothing."""

    def drop(self) -> None:
        """Do nothing: the first one ends it."""
