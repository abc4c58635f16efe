"""The robots of a simulator: their actions, selectors of robots, and the latest messages of their topics.

A selector is ``all``, ``type:nurse``, ``action:pickup`` or ``component:claw``.

In lockstep the message is queried while time stands still, so that a tree sees the same in every run; otherwise the
topic is subscribed to, and each message wakes the trees that watch it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.actions import registry
from hmrsim.diagnostics import instead, meant
from hmrsim.errors import HmrsimError
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.interfaces.vision_msgs import Detection3DArray
from hmrsim_zenoh.errors import RequestError
from hmrsim_zenoh.wire.envelopes import plain, read

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim_zenoh.client.client import Client
    from hmrsim_zenoh.client.subscription import Subscription


class NotServed(HmrsimError):
    """The simulator has no such robot, or the robot no such action; the text lists those that exist."""


@dataclass(frozen=True)
class Directory:
    """The robots in the simulator's ``_world/info``.

    Attributes:
        actions: By robot, the names of its actions.
        aliases: Further names of actions, ``a/b`` to ``robot/action``.
        types: By robot, its type.
        components: By robot, the names of its components, such as ``claw``.
    """

    actions: Mapping[str, tuple[str, ...]]
    aliases: Mapping[str, str]
    types: Mapping[str, str]
    components: Mapping[str, tuple[str, ...]]

    @classmethod
    def from_info(cls, info: Mapping[str, Any]) -> Directory:
        """Return the robots of the simulator's description."""
        robots = {robot["name"]: robot for robot in info.get("robots", ())}
        return cls(
            actions={name: tuple(robot.get("actions", ())) for name, robot in robots.items()},
            aliases=dict(info.get("aliases", {})),
            types={name: robot.get("type", "") for name, robot in robots.items()},
            components={name: tuple(robot.get("components", ())) for name, robot in robots.items()},
        )

    def check_robot(self, robot: str) -> None:
        """Check that a robot exists.

        Raises:
            NotServed: There is no such robot.
        """
        if robot not in self.actions:
            raise NotServed(f"no robot {robot!r}{instead(robot, sorted(self.actions))}")

    def resolve(self, robot: str, action: str) -> tuple[str, str]:
        """Return robot and action for a leaf's action name.

        *action* is a name, or a full name ``robot/action`` or an alias of that; then *robot* doesn't count.

        Raises:
            NotServed: There is no such robot, or it has no such action.
        """
        if "/" in action:
            name = action.strip("/")
            robot, _, action = self.aliases.get(name, name).partition("/")
        self.check_robot(robot)
        if action not in self.actions[robot]:
            known = registry().get(action)
            needs = f", which needs the component {known.component!r}" if known and known.component else ""
            known_actions = instead(action, sorted(self.actions[robot]))
            raise NotServed(f"robot {robot!r} has no action {action!r}{needs}{known_actions}")
        return robot, action


ALL: Final = "all"

_WHAT: Final[Mapping[str, Callable[[Directory, str], tuple[str, ...]]]] = {
    "type": lambda directory, robot: (directory.types[robot],),
    "action": lambda directory, robot: directory.actions[robot],
    "component": lambda directory, robot: directory.components[robot],
}
"""The attributes of a robot by the word before the colon."""


def check_selector(selector: str) -> None:
    """Check the syntax of a selector.

    Raises:
        ValueError: It is invalid.
    """
    kind, _, wanted = selector.partition(":")
    if selector != ALL and not (kind in _WHAT and wanted):
        forms = ", ".join(f"{kind}:NAME" for kind in _WHAT)
        raise ValueError(f"{selector!r} selects no robots; expected {ALL}, {forms}")


def selected(directory: Directory, selectors: Iterable[str]) -> list[str]:
    """Return the names of the robots that match any of the selectors, each once.

    Raises:
        NotServed: A selector matches no robot; the text lists the valid ones.
    """
    return sorted({robot for selector in selectors for robot in _chosen(directory, selector)})


def completions(directory: Directory) -> list[str]:
    """Return all selectors that match a robot."""
    found = {f"{kind}:{name}" for kind in _WHAT for name in _names(directory, kind)}
    return [ALL, *sorted(found)]


def _chosen(directory: Directory, selector: str) -> list[str]:
    if selector == ALL:
        if not directory.actions:
            raise NotServed("there are no robots")
        return list(directory.actions)
    kind, _, wanted = selector.partition(":")
    chosen = [robot for robot in directory.actions if wanted in _WHAT[kind](directory, robot)]
    if not chosen:
        names = _names(directory, kind)
        alike = meant(wanted, names)
        hint = f"; did you mean {kind}:{alike}?" if alike else instead(wanted, names)
        raise NotServed(f"no robot has {kind} {wanted!r}{hint}")
    return chosen


def _names(directory: Directory, kind: str) -> list[str]:
    return sorted({name for robot in directory.actions for name in _WHAT[kind](directory, robot)} - {""})


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
        self._watched: defaultdict[str, int] = defaultdict(int)
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
        """Poll the nodes with conditions on a topic, whose key has no prefix here, since they can't be watched."""
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
        """Unsubscribe from the topics of all robots."""
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
