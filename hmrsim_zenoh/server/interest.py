"""Who listens: one declared publisher for all keys of a kind tells whether anybody subscribes to one of them.

Declaring one a robot would take minutes in large worlds; Zenoh matches wildcards as well.
"""

from __future__ import annotations

import threading
import time
from typing import TYPE_CHECKING, Final, Generic, TypeVar

import zenoh

if TYPE_CHECKING:
    from collections.abc import Callable, Hashable, Mapping

K = TypeVar("K", bound="Hashable")

_LOOK_SECONDS: Final = 0.05
"""Between two looks for who has come or gone, while anybody listens to anything."""
_JOIN_SECONDS: Final = 1.0


class SubscriberWatch(Generic[K]):
    """Whether anybody listens, by whatever kinds of keys there are.

    Args:
        session: Where to look; all ends when it is closed.
        patterns: A key expression for each kind.
        anything: A key expression that includes all others.
        changed: Called in a thread of its own after a kind got its first listener or lost its last.
    """

    def __init__(
        self,
        session: zenoh.Session,
        patterns: Mapping[K, str],
        anything: zenoh.KeyExpr | str,
        changed: Callable[[], None],
    ) -> None:
        self._session = session
        self._changed = changed
        self._lock = threading.Lock()
        self._listened: dict[K, bool] = {}
        self._publishers: dict[K, zenoh.Publisher] = {}
        self._told: dict[K, zenoh.MatchingListener[zenoh.handlers.Handler[zenoh.MatchingStatus]]] = {}
        self._changes = 0
        # Matched by whoever listens to anything: one question where nobody does.
        self._anything = session.declare_publisher(anything)
        for kind, pattern in patterns.items():
            self.watch(kind, pattern)
        self._thread = threading.Thread(target=self._run, name="hmrsim-interest", daemon=True)
        self._thread.start()

    def watch(self, kind: K, pattern: str) -> None:
        """Look for listeners to one more kind, too."""
        publisher = self._session.declare_publisher(pattern)
        told = publisher.declare_matching_listener(zenoh.handlers.RingChannel(1))
        with self._lock:
            self._publishers[kind], self._told[kind], self._listened[kind] = publisher, told, False
            self._update(kind)

    def __contains__(self, kind: object) -> bool:
        """Return whether a kind is watched."""
        return kind in self._publishers

    def __getitem__(self, kind: K) -> bool:
        """Return whether anybody listens to a kind of keys."""
        return self._listened[kind]

    def look(self) -> int:
        """Look for listeners where there were none; return how often anything has changed.

        Whoever subscribes and then sends a goal must see all of it.
        """
        if _matched(self._anything):
            with self._lock:
                for kind, listened in self._listened.items():
                    if not listened:
                        self._update(kind)
        return self._changes

    def in_key(self, key: str) -> bool:
        """Return whether anybody listens to a key just now; slower than to ask for a kind."""
        publisher = self._session.declare_publisher(key)
        try:
            return _matched(publisher)
        finally:
            publisher.undeclare()

    def join(self) -> None:
        """Wait for the end of the thread, after the session was closed.

        One that comes back from Zenoh when Python has ended takes the process down with it.
        """
        self._thread.join(_JOIN_SECONDS)

    def _run(self) -> None:
        """Take note of who comes and goes, until the session is closed.

        A listener for each kind would need a thread of its own: Zenoh's, which a Python callback keeps waiting for the
        GIL, stands still for 10 s when the session is closed meanwhile.
        """
        listener = self._anything.declare_matching_listener(zenoh.handlers.RingChannel(1))
        there = _matched(self._anything)
        try:
            while not self._session.is_closed():
                if there:
                    time.sleep(_LOOK_SECONDS)
                    status = listener.try_recv()
                else:
                    status = listener.recv()
                there = there if status is None else status.matching
                self._take_note()
        except zenoh.ZError:
            return

    def _take_note(self) -> None:
        """Look where Zenoh says that something has changed."""
        with self._lock:
            before = self._changes
            for kind, told in self._told.items():
                if told.try_recv() is not None:
                    self._update(kind)
            changed = self._changes != before
        if changed:
            self._changed()

    def _update(self, kind: K) -> None:
        listened = _matched(self._publishers[kind])
        self._changes += listened != self._listened[kind]
        self._listened[kind] = listened


def _matched(publisher: zenoh.Publisher) -> bool:
    matching: bool = publisher.matching_status.matching  # type: ignore[attr-defined]  # the stub errs
    return matching
