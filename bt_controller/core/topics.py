"""The latest messages of the robots' topics.

In lockstep the message is queried while time stands still, so that a tree sees the same in every run; otherwise the
topic is subscribed to, and each message wakes the trees that watch it.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from bt_controller.core.directory import NotServed
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.interfaces.vision_msgs import Detection3DArray
from hmrsim_zenoh.errors import RequestError
from hmrsim_zenoh.wire.envelopes import plain, read

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.subscription import Subscription

TOPICS: Final[Mapping[str, type[Message]]] = MappingProxyType(
    {"battery_state": BatteryState, "detections": Detection3DArray, "odom": Odometry}
)
"""The topics of robots, and their types."""


_FEW: Final = 4
_SHARE: Final = 16
"""The share of robots (one in this number) that are queried singly at an instant before all robots are queried at once,
which costs a third as much per robot."""


@dataclass
class _Round:
    """The queries of a topic at an instant: their number, and the messages of all robots if those were queried."""

    instant: tuple[float, int]
    asked: int = 0
    all: dict[str, bytes] | None = None


class Topics:
    """The latest messages of the robots' topics.

    Args:
        asks: Whether to query each time instead of subscribing, as in lockstep. Then messages do not wake
            trees.
    """

    def __init__(self, client: Client, *, asks: bool) -> None:
        self._client = client
        self.asks: Final = asks
        self._subscriptions: list[Subscription] = []
        self._received: dict[tuple[str, str], bytes] = {}
        self._wakes: dict[tuple[str, str], list[Callable[[], None]]] = {}
        self._read: dict[tuple[str, str], tuple[object, Message]] = {}
        self._watched: Counter[str] = Counter()
        self._rounds: dict[str, _Round] = {}
        self._changes = 0
        self._unwatchable: set[str] = set()

    def watch(self, robot: str, topic: str, wake: Callable[[], None] | None = None) -> None:
        """Watch a robot's topic; *wake* is called in any thread when there is a new message.

        Raises:
            NotServed: The robot has nothing to publish there.
            SimulatorNotFound, SimulatorGone, Unreachable: No simulator answers.
        """
        watched = robot, topic
        if watched not in self._wakes:
            self._wakes[watched] = []
            self._watched[topic] += 1
            if not self.asks:
                key = self._client.keys.topic(robot, topic)
                self._subscriptions.append(self._client.subscribe(key, partial(self._hear, watched)))
            self._received.setdefault(watched, self._asked(robot, topic) if self.asks else self._ask(robot, topic))
        if wake is not None:
            self._wakes[watched].append(wake)

    def stop_time(self, robot: str, topic: str) -> bool:
        """Return whether time stops for conditions on a topic, so that a node which has some need not be polled."""
        lockstep = self._client.lockstep
        return lockstep is not None and not lockstep.over and f"{robot}/{topic}" not in self._unwatchable

    def poll(self, key: str) -> None:
        """Have nodes polled that have conditions on a topic, by its key without the prefix: they can't be watched."""
        self._unwatchable.add(key)

    def latest(self, robot: str, topic: str) -> Any:
        """Return the latest message of a watched topic; of a disconnected robot, its last one.

        Raises:
            NotServed: The robot has never published a message.
            SimulatorNotFound, SimulatorGone, Unreachable: No simulator answers.
        """
        watched = robot, topic
        # A message is decoded again only for another payload, or in lockstep at another instant.
        mark: object = self._instant if self.asks else self._received[watched]
        known, message = self._read.get(watched, (None, None))
        if message is None or known != mark:
            if self.asks:
                with suppress(NotServed):
                    self._received[watched] = self._asked(robot, topic)
            message = read(plain(TOPICS[topic]), self._received[watched])
            self._read[watched] = mark, message
        return message

    def ask(self, robot: str, topic: str) -> Any:
        """Query the latest message of a topic, watched or not.

        Raises:
            NotServed: The robot has nothing to publish there.
            SimulatorNotFound, SimulatorGone, Unreachable: No simulator answers.
        """
        return read(plain(TOPICS[topic]), self._ask(robot, topic))

    def forget(self) -> None:
        """Drop the cache: messages may have changed, though no time has passed."""
        self._changes += 1

    def close(self) -> None:
        """Unsubscribe from all topics."""
        for subscription in self._subscriptions:
            subscription.close()

    @property
    def _instant(self) -> tuple[float, int]:
        """The key of the cache: the time, and the number of changes."""
        return self._client.now, self._changes

    def _asked(self, robot: str, topic: str) -> bytes:
        """Return a robot's message at this instant; all robots are queried at once if many are needed."""
        instant, watched = self._instant, self._watched[topic]
        found = self._rounds.get(topic)
        if found is None or found.instant != instant:
            found = self._rounds[topic] = _Round(instant)
        found.asked += 1
        if found.asked > max(_FEW, watched // _SHARE) and found.all is None:
            found.all = self._client.get_all(self._client.keys.any_topic(topic))
        payload = (found.all or {}).get(self._client.keys.topic(robot, topic))
        return self._ask(robot, topic) if payload is None else payload

    def _ask(self, robot: str, topic: str) -> bytes:
        try:
            return self._client.get(self._client.keys.topic(robot, topic))
        except RequestError as error:
            raise NotServed(str(error)) from None

    def _hear(self, watched: tuple[str, str], _key: str, payload: bytes) -> None:
        self._received[watched] = payload
        for wake in self._wakes[watched]:
            wake()
