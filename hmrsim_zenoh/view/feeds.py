"""Zenoh subscriptions that pages with the same key share, and the log of the latest events.

Samples stay in Zenoh's ring buffer until the next frame or request: no Python runs in Zenoh's threads, so a slow server
never blocks a publisher. All functions are for the event loop's thread.
"""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, Final

import zenoh

from hmrsim_zenoh.view.frames import embedded, is_json

if TYPE_CHECKING:
    import asyncio

_RING: Final = 8_192
"""The largest number of samples of a subscription between two frames."""

_log = logging.getLogger(__name__)


Listener = Callable[[Sequence[tuple[str, str]], bool], None]
"""Processes new samples in order, each a key and its text in a frame; the flag tells whether some are missing."""


class Feeds:
    """The subscriptions of one session."""

    def __init__(self, session: zenoh.Session, prefix: str, loop: asyncio.AbstractEventLoop) -> None:
        self._session = session
        self._prefix = f"{prefix}/"
        self._loop = loop
        self._feeds: dict[tuple[str, float], _Feed] = {}

    def __len__(self) -> int:
        """Return the number of Zenoh subscriptions."""
        return len(self._feeds)

    def subscribe(self, key: str, every: float, listener: Listener) -> None:
        """Call a listener with the samples of a key below the prefix, once per *every* seconds."""
        feed = self._feeds.get((key, every))
        if feed is None:
            feed = self._feeds[key, every] = _Feed(self._session, self._prefix, key, every, self._loop)
        feed.listeners[listener] = None

    def unsubscribe(self, key: str, every: float, listener: Listener) -> None:
        """Stop calling a listener."""
        feed = self._feeds[key, every]
        del feed.listeners[listener]
        if not feed.listeners:
            self._feeds.pop((key, every)).close()

    def close(self) -> None:
        """Close all subscriptions."""
        while self._feeds:
            self._feeds.popitem()[1].close()


class _Feed:
    """A Zenoh subscription and its listeners, in order."""

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
                _log.debug("a message on %r is not JSON", key)
            else:
                entries.append((key, text))
        if came:
            # The ring was full, so there may have been more.
            lost = came == _RING
            for listener in list(self.listeners):
                listener(entries, lost)


MAX_EVENTS: Final = 500


class EventLog:
    """Keeps the latest events of a simulator; for the event loop's thread.

    They stay in Zenoh's ring buffer until a page requests them, so that no Python runs for each.
    """

    def __init__(self, session: zenoh.Session, key: str) -> None:
        ring: zenoh.handlers.RingChannel[zenoh.Sample] = zenoh.handlers.RingChannel(MAX_EVENTS)
        self._subscriber = session.declare_subscriber(key, ring)
        self._events: deque[bytes] = deque(maxlen=MAX_EVENTS)

    def json(self) -> bytes:
        """Return the events as a JSON list, oldest first."""
        self._events.extend(filter(is_json, self._new()))
        return b"[%b]" % b",".join(self._events)

    def clear(self) -> None:
        """Drop all events, since another simulator has started."""
        self._events.clear()
        for _ in self._new():
            pass

    def close(self) -> None:
        """End the subscription to the events."""
        self._subscriber.undeclare()

    def _new(self) -> Iterator[bytes]:
        for _ in range(MAX_EVENTS):
            sample = self._subscriber.try_recv()
            if sample is None:
                return
            yield sample.payload.to_bytes()
