"""The status and feedback topics of actions."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import compress, count
from operator import is_not
from struct import Struct
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.interfaces.builtin_interfaces import values_of
from hmrsim.protocol.goal import WORLD
from hmrsim.protocol.topics import Topic
from hmrsim_zenoh.ros2.keys import DEFAULT_QOS, LATCHED_QOS, Endpoint, Kind
from hmrsim_zenoh.server.publisher import FeedbackLimiter

if TYPE_CHECKING:
    from hmrsim.protocol.goal import GoalEntry
    from hmrsim.protocol.outputs import FeedbackSent, StatusChanged
    from hmrsim_zenoh.ros2.codec.types import MessageType
    from hmrsim_zenoh.ros2.names import Names
    from hmrsim_zenoh.ros2.publishing.endpoints import Endpoints
    from hmrsim_zenoh.ros2.publishing.publishers import Publisher, Publishers
    from hmrsim_zenoh.ros2.wires import Wire
    from hmrsim_zenoh.server.interest import SubscriberWatch

_ENTRY: Final = Struct("<16s3xiIb")
"""An entry of an encoded status list: the goal's id, its stamp and its status."""
_PADDING: Final = slice(16, 19)
"""The padding of an entry, between the goal's id and its stamp; the first entry of a list has none."""


class Statuses:
    """An encoder of status lists, which caches entries because most of a long list does not change."""

    def __init__(self) -> None:
        self._goals: list[GoalEntry] = []
        self._encoded: list[bytes] = []

    def encode(self, goals: Sequence[GoalEntry]) -> bytes:
        """Return the encoded status list of these goals."""
        self._drop_oldest(goals)
        # A Python loop over all entries would take most of the time: identical ones are skipped in C.
        for i in compress(count(), map(is_not, goals, self._goals)):
            if self._goals[i] != goals[i]:
                self._encoded[i] = _entry(goals[i])
        self._encoded[len(self._goals) :] = map(_entry, goals[len(self._goals) :])
        del self._encoded[len(goals) :]
        self._goals = list(goals)
        entries = self._encoded
        first = entries[0][: _PADDING.start] + entries[0][_PADDING.stop :] if entries else b""
        return b"\0\1\0\0%b%b%b" % (len(entries).to_bytes(4, "little"), first, b"".join(entries[1:]))

    def _drop_oldest(self, goals: Sequence[GoalEntry]) -> None:
        """Drop the cached entries of goals that have expired, so that the indices match again."""
        oldest = goals[0].goal_id if goals else ""
        expired = next((i for i, goal in enumerate(self._goals) if goal.goal_id == oldest), len(self._goals))
        del self._goals[:expired], self._encoded[:expired]


def _entry(goal: GoalEntry) -> bytes:
    """Return the encoded entry of a goal, with padding."""
    return _ENTRY.pack(bytes.fromhex(goal.goal_id), *values_of(goal.stamp).values(), goal.status)


_OF_ROBOTS, _OF_WORLD = "/*/*/_action/feedback", "/*/_action/feedback"
"""The topic names of the feedback of robots' actions, and of the world's actions."""
FEEDBACK: Final = (_OF_ROBOTS, _OF_WORLD)


class _Layout(NamedTuple):
    """A feedback topic in one message layout, which one or more ROS distributions use."""

    type: MessageType
    pattern: str
    """The key pattern on which `SubscriberWatch` checks for subscribers to any robot's feedback."""
    publishers: list[Publisher]


class _Goals(NamedTuple):
    """The publishers of status and feedback of one action of one robot."""

    statuses: Statuses
    status: list[Publisher]
    feedback: list[_Layout]


class GoalTopics:
    """Publishes statuses always, as they are latched, and feedback if it has subscribers."""

    def __init__(
        self, wire: Wire, endpoints: Endpoints, publishers: Publishers, interest: SubscriberWatch[str]
    ) -> None:
        self._wire = wire
        self._endpoints = endpoints
        self._publishers = publishers
        self._interest = interest
        self._limiter = FeedbackLimiter()
        # Keeps the latched publishers alive: they hold their message until they are declared.
        self._robots: dict[str, dict[str, _Goals]] = {}

    def wants(self, topic: Topic) -> bool:
        """Return whether statuses or feedback are needed."""
        if topic is Topic.FEEDBACK:
            return any(self._interest[kind] for kind in FEEDBACK)
        return topic is Topic.STATUS

    def kinds(self, action: str, *, of_world: bool) -> list[str]:
        """Return the key patterns of an action's feedback: the general one, and those of the layouts sent so far."""
        sent = [pattern for _, pattern in self._patterns(action, of_world=of_world) if pattern in self._interest]
        return [_OF_WORLD if of_world else _OF_ROBOTS, *sent]

    def begin(self, robot: str, names: Names) -> None:
        """Publish empty status lists for all actions of a robot."""
        type_ = self._endpoints.status_type
        actions = self._robots[robot] = {}
        for action in names.serves[robot]:
            publishers = self._of(names.called(robot, action), "status", type_, LATCHED_QOS)
            actions[action] = _Goals(Statuses(), publishers, [])
            for publisher in publishers:
                publisher.publish(type_.encode({"status_list": []}))

    def knows(self, robot: str) -> bool:
        """Return whether a robot's goals are published."""
        return robot in self._robots

    def end(self, robot: str) -> None:
        """Stop publishing for a robot."""
        self._robots.pop(robot, None)

    def forget(self, goal_id: str) -> None:
        """Forget a goal that has ended."""
        self._limiter.forget(goal_id)

    def emit_status(self, event: StatusChanged) -> None:
        """Publish the statuses of an action's goals."""
        goals = self._goals(event)
        if goals is not None:
            payload = goals.statuses.encode(event.goals)
            for publisher in goals.status:
                publisher.publish(payload)

    def emit_feedback(self, event: FeedbackSent, names: Names) -> None:
        """Publish feedback in the layouts that have subscribers."""
        goals = self._goals(event)
        if goals is None or not self.wants(Topic.FEEDBACK) or not self._limiter.passes(event):
            return
        if not goals.feedback:
            goals.feedback.extend(self._layouts(event, names))
        for layout in goals.feedback:
            if self._interest[layout.pattern] and any(layout.publishers):
                goal_id = {"uuid": bytes.fromhex(event.goal_id)}
                payload = layout.type.encode({"goal_id": goal_id, "feedback": event.feedback})
                for publisher in layout.publishers:
                    publisher.publish(payload)

    def _goals(self, event: StatusChanged | FeedbackSent) -> _Goals | None:
        actions = self._robots.get(event.robot)
        return actions.get(event.action) if actions else None

    def _layouts(self, event: FeedbackSent, names: Names) -> Iterator[_Layout]:
        called = names.called(event.robot, event.action)
        for type_, pattern in self._patterns(event.action, of_world=event.robot == WORLD):
            if pattern not in self._interest:
                self._interest.watch(pattern, pattern)
            yield _Layout(type_, pattern, self._of(called, "feedback", type_, DEFAULT_QOS))

    def _patterns(self, action: str, *, of_world: bool) -> Iterator[tuple[MessageType, str]]:
        """Yield the message types of an action's feedback, each with its key pattern."""
        for type_ in self._endpoints.feedback_types(action):
            yield type_, self._wire.key(_OF_WORLD if of_world else _OF_ROBOTS, type_.dds_name, type_.hash)

    def _of(self, names: Iterable[str], role: str, type_: MessageType, qos: str) -> list[Publisher]:
        return [
            self._publishers.of(Endpoint(Kind.PUBLISHER, f"{name}/_action/{role}", type_.dds_name, type_.hash, qos))
            for name in names
        ]
