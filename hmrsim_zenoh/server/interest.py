"""Detection of subscribers: one publisher for all keys of a kind shows whether any of them has a subscriber.

A publisher for each robot would take minutes to declare in large worlds; Zenoh matches key expressions as well.
"""

from __future__ import annotations

import threading
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping
from typing import Final, Generic, TypeVar

import zenoh

from hmrsim_zenoh.wire.keys import servers_own

K = TypeVar("K", bound="Hashable")

_LOOK_SECONDS: Final = 0.05
"""Wall seconds between two checks for new or gone subscribers, while there is any subscriber."""
_JOIN_SECONDS: Final = 1.0


class Interest(ABC, Generic[K]):
    """Knows which kinds of keys have subscribers.

    Attributes:
        any: Whether any kind has a subscriber.
    """

    def __init__(self, kinds: Iterable[K]) -> None:
        self.any = False
        self._listened = dict.fromkeys(kinds, False)
        self._changes = 0

    def __getitem__(self, kind: K) -> bool:
        """Return whether a kind of keys has a subscriber."""
        return self._listened[kind]

    @abstractmethod
    def look(self, kinds: Collection[K] | None = None) -> int:
        """Check the kinds that had no subscriber, or some of them; return the number of changes so far.

        This lets a client that subscribes and then sends a goal receive everything about the goal.
        """

    @abstractmethod
    def in_key(self, key: str) -> bool:
        """Return whether a key has a subscriber now; slower than the check of a kind."""

    def join(self) -> None:
        """Wait for the end of the detection, after the session was closed."""


class SubscriberWatch(Interest[K]):
    """Detects the subscribers of each kind of keys over Zenoh.

    Args:
        session: The session to look on; closing it ends the detection.
        anything: A key expression that includes all others.
        changed: Called in a separate thread after a kind got its first subscriber or lost its last one.
    """

    def __init__(
        self, session: zenoh.Session, patterns: Mapping[K, str], anything: str, changed: Callable[[], None]
    ) -> None:
        super().__init__(patterns)
        self._session = session
        self._changed = changed
        self._lock = threading.Lock()
        self._publishers: dict[K, zenoh.Publisher] = {}
        self._listeners: dict[K, zenoh.MatchingListener[zenoh.handlers.Handler[zenoh.MatchingStatus]]] = {}
        # Not Session.is_closed(): it raises RuntimeError while another thread closes the session.
        self._ended = threading.Event()
        # Matches every subscriber: a single check where there is none.
        self._anything = session.declare_publisher(servers_own(anything))
        for kind, pattern in patterns.items():
            self.watch(kind, pattern)
        self._thread = threading.Thread(target=self._run, name="hmrsim-interest", daemon=True)
        self._thread.start()

    def watch(self, kind: K, pattern: str) -> None:
        """Watch one more kind of keys."""
        publisher = self._session.declare_publisher(servers_own(pattern))
        listener = publisher.declare_matching_listener(zenoh.handlers.RingChannel(1))
        with self._lock:
            self._publishers[kind], self._listeners[kind], self._listened[kind] = publisher, listener, False
            self._update(kind)

    def __contains__(self, kind: object) -> bool:
        """Return whether a kind is watched."""
        return kind in self._publishers

    def look(self, kinds: Collection[K] | None = None) -> int:
        """Check the kinds that had no subscriber, or some of them; return how often anything has changed."""
        if self.any or _matched(self._anything):
            with self._lock:
                for kind in kinds or self._listened:
                    if not self._listened[kind] and _matched(self._publishers[kind]):
                        self._update(kind)
        return self._changes

    def in_key(self, key: str) -> bool:
        """Return whether a key has a subscriber now; slower than the check of a kind."""
        publisher = self._session.declare_publisher(key)
        try:
            return _matched(publisher)
        finally:
            publisher.undeclare()

    def join(self) -> None:
        """Wait for the thread to end, after the session was closed.

        A thread that returns from Zenoh after Python has ended crashes the process.
        """
        self._ended.set()
        self._thread.join(_JOIN_SECONDS)

    def _run(self) -> None:
        """Track subscribers until the session is closed.

        A matching listener for each kind would need its own thread: Zenoh's thread, which a Python callback keeps
        waiting for the GIL, blocks for 10 s when the session is closed meanwhile.
        """
        try:
            listener = self._anything.declare_matching_listener(zenoh.handlers.RingChannel(1))
            there = _matched(self._anything)
            while not self._ended.is_set():
                if there:
                    self._ended.wait(_LOOK_SECONDS)
                    status = listener.try_recv()
                else:
                    status = listener.recv()
                there = there if status is None else status.matching
                self._update_changed()
        except zenoh.ZError:
            return

    def _update_changed(self) -> None:
        """Check the kinds whose matching status has changed."""
        with self._lock:
            before = self._changes
            for kind, listener in self._listeners.items():
                if listener.try_recv() is not None:
                    self._update(kind)
            changed = self._changes != before
        if changed:
            self._changed()

    def _update(self, kind: K) -> None:
        listened = _matched(self._publishers[kind])
        self._changes += listened != self._listened[kind]
        self._listened[kind] = listened
        self.any = listened or True in self._listened.values()


def _matched(publisher: zenoh.Publisher) -> bool:
    matching: bool = publisher.matching_status.matching  # type: ignore[attr-defined]  # the stub errs
    return matching
