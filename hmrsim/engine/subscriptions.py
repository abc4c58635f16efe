"""The topics that have subscribers, as no others are computed, and the publisher of the world's events."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, Protocol

from hmrsim.protocol.outputs import EventStamped, Sampled
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.sinks import Sink


_NAMES: Final = {topic: topic.name.lower() for topic in Topic}


class Interest:
    """The topics that a sink wants; cached, as they are read many times per event, and updated by `refresh` only.

    Args:
        sinks: All sinks; sinks that are added take effect with the next `refresh`.

    Each attribute says whether a sink wants the `Topic` of its name.
    """

    status: bool
    feedback: bool
    odom: bool
    battery_state: bool
    detections: bool
    clock: bool
    events: bool
    motion: bool
    time: bool

    def __init__(self, sinks: Sequence[Sink]) -> None:
        self._sinks = sinks
        self.refresh()

    def refresh(self) -> None:
        """Refresh the topics that the sinks want."""
        for topic, name in _NAMES.items():
            setattr(self, name, True in [sink.wants(topic) for sink in self._sinks])

    def in_(self, topic: Topic) -> bool:
        """Return whether a sink wants a topic."""
        wanted: bool = getattr(self, _NAMES[topic])
        return wanted

    @property
    def sampled(self) -> bool:
        """Return whether a sink wants a topic that is sampled between events."""
        return self.feedback or self.odom or self.clock or self.battery_state or self.detections


class Clock(Protocol):
    """A source of the simulated time."""

    @property
    def stamp(self) -> int:
        """The stamp of this instant."""


class EventPublisher:
    """Publishes the events of the world, if a sink wants them.

    Attributes:
        interest: To be checked before frequent events are published.
        emit: For outputs that are no events of the world.
    """

    def __init__(self, clock: Clock, interest: Interest, emit: Callable[[Output], None]) -> None:
        self.interest = interest
        self._clock = clock
        self.emit = emit

    def publish(self, make: Callable[[], Event]) -> None:
        """Publish an event of this instant; it is built only if a sink wants it."""
        if self.interest.events:
            self.emit(EventStamped(self._clock.stamp, make()))

    def publish_untraced(self, make: Callable[[], Event]) -> None:
        """Publish an event that is not recorded in traces."""
        if self.interest.motion:
            self.emit(EventStamped(self._clock.stamp, make()))

    def sampled(self, topic: Topic, robot: str, message: Callable[[], Message]) -> None:
        """Publish the current message of a robot's topic, as it has changed, if a sink wants it."""
        if self.interest.in_(topic):
            self.emit(Sampled(topic, robot, message()))
