"""Injected faults of communication: answers that get lost, and requests that arrive twice."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, cast

from hmrsim.protocol.commands import without_receivers

if TYPE_CHECKING:
    from collections.abc import Callable

    import zenoh

    from hmrsim.protocol.commands import AnyCommand


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
        """Deliver each of the next requests twice."""
        self._requests += count
        self.active = True

    def arrive(self, query: zenoh.Query, decode: Callable[[zenoh.Query], list[AnyCommand]]) -> list[AnyCommand]:
        """Return the commands of a query, which may arrive twice; the client gets the answer to the first one."""
        payload = query.payload
        if payload is None or not payload.to_bytes():
            return decode(query)
        commands = decode(cast("zenoh.Query", _Watched(query, self)) if self.watching else query)
        return [*commands, *map(unanswered, commands)] if self.comes_twice() else commands

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


def unanswered(command: Any) -> Any:
    """Return a command whose answer no client gets."""
    command = without_receivers(command)
    return command._replace(reply_to=None) if hasattr(command, "reply_to") else command
