"""Who listens: one declared publisher a topic tells whether anybody subscribes to it on any robot.

Declaring one a robot would take minutes in large worlds; Zenoh matches wildcards as well.
"""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING

import zenoh

from hmrsim.gateway import Topic
from hmrsim_zenoh.keys import Verb

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim_zenoh.keys import Keys


class Interest:
    """Whether anybody listens, by topic.

    Args:
        session: Where to look.
        keys: How keys are spelled.
        changed: Called in one of Zenoh's threads after a topic got its first listener or lost its last.
    """

    def __init__(self, session: zenoh.Session, keys: Keys, changed: Callable[[], None]) -> None:
        self._session = session
        self._changed = changed
        self._lock = threading.Lock()
        self._listened: dict[Topic, bool] = dict.fromkeys(Topic, False)
        self._changes = 0
        patterns = {
            Topic.STATUS: keys.any_action(Verb.STATUS),
            Topic.FEEDBACK: keys.any_action(Verb.FEEDBACK),
            **{topic: keys.any_topic(topic.value) for topic in (Topic.ODOM, Topic.BATTERY_STATE, Topic.DETECTIONS)},
            Topic.CLOCK: keys.world("clock"),
            Topic.EVENTS: keys.world("events"),
            Topic.MOTION: keys.world("events"),
            Topic.TIME: keys.world("time/state"),
        }
        # Matched by whoever listens to anything: one question where nobody does.
        self._anything = session.declare_publisher(keys.everything())
        # The listeners live as long as the publishers do, and these as long as this object.
        self._publishers = {topic: self._watch(session, topic, pattern) for topic, pattern in patterns.items()}
        for topic, publisher in self._publishers.items():
            self._update(topic, publisher)

    def __getitem__(self, topic: Topic) -> bool:
        """Return whether anybody listens to a topic."""
        return self._listened[topic]

    def look(self) -> int:
        """Look for listeners where there were none; return how often anything has changed.

        Zenoh tells of a listener in a thread of its own, which may be after the request that the same client made
        next: whoever subscribes and then sends a goal must see all of it.
        """
        if _matched(self._anything):
            for topic, listened in self._listened.items():
                if not listened:
                    self._update(topic, self._publishers[topic])
        return self._changes

    def in_key(self, key: str) -> bool:
        """Return whether anybody listens to a key just now; slower than to ask for a topic."""
        publisher = self._session.declare_publisher(key)
        try:
            return _matched(publisher)
        finally:
            publisher.undeclare()

    def _watch(self, session: zenoh.Session, topic: Topic, pattern: str) -> zenoh.Publisher:
        publisher = session.declare_publisher(pattern)

        def update(_status: zenoh.MatchingStatus) -> None:
            self._update(topic, publisher)
            self._changed()

        publisher.declare_matching_listener(zenoh.handlers.Callback(update))
        return publisher

    def _update(self, topic: Topic, publisher: zenoh.Publisher) -> None:
        """Note what is so now: what a listener was told may be out of date already."""
        with self._lock:
            matched = _matched(publisher)
            self._changes += matched != self._listened[topic]
            self._listened[topic] = matched


def _matched(publisher: zenoh.Publisher) -> bool:
    matching: bool = publisher.matching_status.matching  # type: ignore[attr-defined]  # the stub errs
    return matching
