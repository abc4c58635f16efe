"""A monitor of whether keys have subscribers."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

from tests.patience import PATIENCE

if TYPE_CHECKING:
    import zenoh


class Listened:
    """Follows whether keys have subscribers.

    One publisher stays declared for each key: Zenoh 1.x can keep a subscriber that is undeclared while one publisher
    of its key goes and another one comes.
    """

    def __init__(self, session: zenoh.Session) -> None:
        self._session = session
        self._publishers: dict[str, zenoh.Publisher] = {}
        self._changed = threading.Condition()

    def now(self, key: str) -> bool:
        """Return whether a key has a subscriber."""
        return bool(self._publisher(key).matching_status.matching)

    def wait(self, key: str, *, there: bool) -> None:
        """Wait until a key has a subscriber, or until it has none."""
        with self._changed:
            assert self._changed.wait_for(lambda: self.now(key) == there, PATIENCE)

    def _publisher(self, key: str) -> zenoh.Publisher:
        if key not in self._publishers:
            self._publishers[key] = publisher = self._session.declare_publisher(key)
            publisher.declare_matching_listener(lambda _status: self._note())
        return self._publishers[key]

    def _note(self) -> None:
        with self._changed:
            self._changed.notify_all()
