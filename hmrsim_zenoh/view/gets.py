"""Queries of pages, whose replies arrive in Zenoh's threads."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import zenoh

_MAX_REPLIED: Final = 32 * 2**20
"""The largest number of bytes of the replies to one query."""


@dataclass(frozen=True)
class Replies:
    """The replies to a query.

    Attributes:
        ok: Keys and payloads.
        errors: The payloads of Zenoh's error replies.
        cut: Whether the replies were too large.
    """

    ok: list[tuple[str, bytes]]
    errors: list[bytes]
    cut: bool


class Gets:
    """Sends queries below a prefix.

    Args:
        later: Schedules a call in the event loop's thread.
    """

    def __init__(self, session: zenoh.Session, prefix: str, later: Callable[[Callable[[], None]], None]) -> None:
        self.prefix = prefix
        self._session = session
        self._later = later

    def get(self, key: str, payload: bytes | None, timeout: float, then: Callable[[Replies], None]) -> None:
        """Send a query; *then* receives all replies after the last one has arrived.

        Raises:
            zenoh.ZError: The session is closed.
        """
        ok: list[tuple[str, bytes]] = []
        errors: list[bytes] = []
        room = _MAX_REPLIED

        def on_reply(reply: zenoh.Reply) -> None:
            nonlocal room
            if reply.ok is None:
                errors.append(reply.err.payload.to_bytes() if reply.err else b"")
                return
            room -= len(reply.ok.payload)
            if room >= 0:
                ok.append((str(reply.ok.key_expr)[len(self.prefix) + 1 :], reply.ok.payload.to_bytes()))

        handler: zenoh.handlers.Callback[zenoh.Reply] = zenoh.handlers.Callback(
            on_reply, lambda: self._later(lambda: then(Replies(ok, errors, cut=room < 0))), indirect=False
        )
        # Zenoh's best match would be the simulator alone, but each robot's controller answers for its tree.
        target = zenoh.QueryTarget.ALL if "*" in key else zenoh.QueryTarget.BEST_MATCHING
        where = f"{self.prefix}/{key}"
        self._session.get(where, handler, payload=payload, encoding="application/json", timeout=timeout, target=target)
