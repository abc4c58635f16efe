"""Zenoh's subscriptions, shared by all pages that want the same.

Samples wait in Zenoh's own ring until it is time for a frame: no Python runs in Zenoh's threads, so that whatever the
server does, no publisher has to wait for it. All of this is for the event loop's thread.
"""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final, Protocol

import zenoh

from hmrsim_zenoh.view.frames import embedded

if TYPE_CHECKING:
    import asyncio
    from collections.abc import Sequence

_RING: Final = 8_192
"""Samples of one subscription that are kept between two frames, and so the most that are looked at then."""

_log = logging.getLogger(__name__)


class Listener(Protocol):
    """Who wants samples."""

    def hear(self, entries: Sequence[tuple[str, str]], *, lost: bool) -> None:
        """Take what came since the last time, each a key and its sample in a frame, in order."""


class Feeds:
    """The subscriptions of one session.

    Args:
        session: An open session.
        prefix: What all keys begin with.
        loop: The event loop.
    """

    def __init__(self, session: zenoh.Session, prefix: str, loop: asyncio.AbstractEventLoop) -> None:
        self._session = session
        self._prefix = f"{prefix}/"
        self._loop = loop
        self._feeds: dict[tuple[str, float], _Feed] = {}

    def __len__(self) -> int:
        """Return how many subscriptions Zenoh has of us."""
        return len(self._feeds)

    def join(self, key: str, every: float, listener: Listener) -> None:
        """Call a listener with the samples of a key below the prefix, each *every* seconds."""
        feed = self._feeds.get((key, every))
        if feed is None:
            feed = self._feeds[key, every] = _Feed(self._session, self._prefix, key, every, self._loop)
        feed.listeners[listener] = None

    def leave(self, key: str, every: float, listener: Listener) -> None:
        """Call a listener no more."""
        feed = self._feeds[key, every]
        del feed.listeners[listener]
        if not feed.listeners:
            self._feeds.pop((key, every)).close()

    def close(self) -> None:
        """End all."""
        while self._feeds:
            self._feeds.popitem()[1].close()


class _Feed:
    """One subscription of Zenoh's, and those who listen to it, in order."""

    def __init__(
        self, session: zenoh.Session, prefix: str, key: str, every: float, loop: asyncio.AbstractEventLoop
    ) -> None:
        self.listeners: dict[Listener, None] = {}
        self._prefix = prefix
        self._every = every
        self._loop = loop
        ring: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(_RING)
        self._subscriber = session.declare_subscriber(prefix + key, ring)
        self._timer = loop.call_later(every, self._flush)

    def close(self) -> None:
        self._timer.cancel()
        self._subscriber.undeclare()

    def _flush(self) -> None:
        self._timer = self._loop.call_later(self._every, self._flush)
        came = 0
        entries = []
        while came < _RING and (sample := self._subscriber.try_recv()) is not None:
            came += 1
            key = str(sample.key_expr)[len(self._prefix) :]
            text = embedded(key, sample.payload.to_bytes())
            if text is None:
                _log.debug("what was published on %r is no JSON", key)
            else:
                entries.append((key, text))
        if came:
            # As many as there is room for: there may have been more.
            lost = came == _RING
            for listener in list(self.listeners):
                listener.hear(entries, lost=lost)
