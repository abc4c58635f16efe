"""The latest events, for pages that open later."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import Final

import zenoh

from hmrsim_zenoh.view.frames import is_json

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
        """Unsubscribe."""
        self._subscriber.undeclare()

    def _new(self) -> Iterator[bytes]:
        for _ in range(MAX_EVENTS):
            sample = self._subscriber.try_recv()
            if sample is None:
                return
            yield sample.payload.to_bytes()
