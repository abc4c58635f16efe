"""The topics that have subscribers, so that no other is computed, and the publisher of the world's events."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.engine.sim_time import stamp
from hmrsim.protocol.outputs import EventStamped, Sampled
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    import simpy

    from hmrsim.events import Event as WorldEvent
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.outputs import Event
    from hmrsim.protocol.sinks import Sink


class Interest:
    """The topics that any sink wants; asked many times an event, so the sinks themselves are asked in `refresh` only.

    Args:
        sinks: All sinks; more may be added, which takes effect with the next `refresh`.

    Attributes:
        status: Whether a sink wants `Topic.STATUS`.
        feedback: Likewise.
        odom: Likewise.
        battery_state: Likewise.
        detections: Likewise.
        clock: Likewise.
        events: Likewise.
        motion: Likewise.
    """

    status: bool
    feedback: bool
    odom: bool
    battery_state: bool
    detections: bool
    clock: bool
    events: bool
    motion: bool

    def __init__(self, sinks: Sequence[Sink]) -> None:
        self._sinks = sinks
        self.refresh()

    def refresh(self) -> None:
        """Ask all sinks again."""
        for topic in Topic:
            setattr(self, topic.name.lower(), any(sink.wants(topic) for sink in self._sinks))

    def in_(self, topic: Topic) -> bool:
        """Return whether a sink wants a topic."""
        wanted: bool = getattr(self, topic.name.lower())
        return wanted

    @property
    def sampled(self) -> bool:
        """Whether a sink wants a topic that is sampled between events."""
        return self.feedback or self.odom or self.clock or self.battery_state or self.detections


class EventPublisher:
    """Publishes what happens in the world, if a sink wants to know.

    Args:
        env: The simulation's clock.
        interest: Who listens.
        emit: Where events go.

    Attributes:
        interest: Who listens; to be asked first by what happens often.
    """

    def __init__(self, env: simpy.Environment, interest: Interest, emit: Callable[[Event], None]) -> None:
        self.interest = interest
        self._env = env
        self._emit = emit

    def publish(self, make: Callable[[], WorldEvent]) -> None:
        """Publish an event of this instant; it is made only if it is wanted."""
        if self.interest.events:
            self._emit(EventStamped(stamp(self._env.now), make()))

    def publish_untraced(self, make: Callable[[], WorldEvent]) -> None:
        """Likewise one that no trace has."""
        if self.interest.motion:
            self._emit(EventStamped(stamp(self._env.now), make()))

    def sampled(self, topic: Topic, robot: str, message: Callable[[], Message]) -> None:
        """Publish what a topic of a robot is now, since it has changed, if it is wanted."""
        if self.interest.in_(topic):
            self._emit(Sampled(topic, robot, message()))
