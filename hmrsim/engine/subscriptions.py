"""Subscribed topics, their sampling, and the publisher of the world's events; topics without subscribers cost nothing.

Samples are not events of the simulation: they change no state and are not part of the trace. Sampling times are whole
multiples of the period after a sampler's start, in simulated time.
"""

from __future__ import annotations

import heapq
import math
from collections.abc import Callable, Collection, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, Protocol

from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.outputs import EventStamped, Sampled
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Topic

if TYPE_CHECKING:
    from hmrsim.events import Event
    from hmrsim.interfaces.message import Message
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.sinks import Sink

_NAMES: Final = {topic: topic.name.lower() for topic in Topic}


class Reaction(Protocol):
    """A part of the simulation that acts on outputs, each before the sinks observe it."""

    @property
    def topics(self) -> Collection[Topic]:
        """The topics that the part needs now."""

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""


class Interest:
    """The topics that are wanted; cached, as they are read many times per event, and updated by `refresh` only.

    Args:
        reactions: The parts of the simulation that act on outputs.
        sinks: All sinks; those that are added take effect with the next `refresh`, as reactions do.

    Each attribute says whether a reaction or a sink wants the `Topic` of its name, and *sampled* whether any wants one
    that is sampled between events; *topics* are all that are wanted.
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
    sampled: bool
    topics: Collection[Topic]

    def __init__(self, reactions: Sequence[Reaction], sinks: Sequence[Sink]) -> None:
        self._reactions = reactions
        self._sinks = sinks
        self.refresh()

    def refresh(self) -> None:
        """Refresh the topics that are wanted."""
        wanted: set[Topic] = set()
        for sink in self._sinks:
            if isinstance(sink, SelectiveSink) and type(sink).wants is SelectiveSink.wants:
                wanted.update(sink.topics)
            else:
                wanted.update(filter(sink.wants, _NAMES))
        for part in self._reactions:
            wanted.update(part.topics)
        self.topics = wanted
        for topic, name in _NAMES.items():
            setattr(self, name, topic in wanted)
        self.sampled = self.feedback or self.odom or self.clock or self.battery_state or self.detections


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
        handlers: The functions that process each type of output emitted since sinks or reactions have changed.
    """

    def __init__(
        self,
        clock: Clock,
        interest: Interest,
        emit: Callable[[Output], None],
        handlers: Mapping[type, Sequence[object]],
    ) -> None:
        self.interest = interest
        self._clock = clock
        self.emit = emit
        self.handlers = handlers

    def publish(self, make: Callable[[], Event]) -> None:
        """Publish an event of this instant; it is built only if a sink wants it."""
        if self.interest.events:
            self.emit(EventStamped(self._clock.stamp, make()))

    def announce(self, event: Event) -> None:
        """Publish a rare event of this instant, also if no sink wants all events: a sink may look for it alone."""
        self.emit(EventStamped(self._clock.stamp, event))

    def publish_untraced(self, make: Callable[[], Event]) -> None:
        """Publish an event that is not recorded in traces."""
        if self.interest.motion:
            self.emit(EventStamped(self._clock.stamp, make()))

    def sampled(self, topic: Topic, robot: str, message: Callable[[], Message]) -> None:
        """Publish the current message of a robot's topic, which has changed, if a sink needs it."""
        if topic in self.interest.topics:
            self.emit(Sampled(topic, robot, message()))


@dataclass(eq=False)
class _Sampler:
    topic: Topic
    start: float
    period: float
    take: Callable[[], None]
    stopped: bool = False

    def due_after(self, now: float) -> float:
        """Return the first sampling time after the instant of *now*; like every instant, it is a whole nanosecond."""
        instant = round(now * NANOSECONDS)
        number = math.floor((now - self.start) / self.period)
        while (due := round((self.start + number * self.period) * NANOSECONDS)) <= instant:
            number += 1
        return due / NANOSECONDS


class Telemetry:
    """All samplers, and when the next one is due."""

    def __init__(self, interest: Interest) -> None:
        self._interest = interest
        self._samplers: dict[Hashable, _Sampler] = {}
        self._heap: list[tuple[float, int, _Sampler]] = []
        self._order = 0

    @property
    def next_due(self) -> float:
        """When the next sample is due; infinite without a subscriber."""
        while self._heap and self._heap[0][2].stopped:
            heapq.heappop(self._heap)
        return self._heap[0][0] if self._heap else math.inf

    def start(
        self, key: Hashable, topic: Topic, begin: float, rate: float, take: Callable[[], None], *, now: float = 0.0
    ) -> None:
        """Sample *take* from *now* on, at *rate* samples a second since *begin*; *key* stops it again."""
        sampler = self._samplers[key] = _Sampler(topic, begin, 1.0 / rate, take)
        if topic in self._interest.topics:
            self._push(sampler, sampler.due_after(max(begin, now)))

    def __contains__(self, key: object) -> bool:
        """Return whether a sampler has this key."""
        return key in self._samplers

    def stop(self, key: Hashable) -> None:
        """Remove the sampler of a key, if there is one."""
        sampler = self._samplers.pop(key, None)
        if sampler:
            sampler.stopped = True

    def refresh(self, now: float) -> None:
        """Start sampling topics that have subscribers now, and stop sampling those that no longer have any."""
        # A sampler that runs already may be due at this very instant.
        due = {sampler: time for time, _, sampler in self._heap}
        self._heap.clear()
        for sampler in self._samplers.values():
            if sampler.topic in self._interest.topics:
                self._push(sampler, min(sampler.due_after(now), due.get(sampler, math.inf)))

    def sample(self, let_it_be: Callable[[float], None]) -> None:
        """Take the next sample, after calling *let_it_be* with its time; there has to be one."""
        due, _, sampler = self._heap[0]
        self._order += 1
        heapq.heapreplace(self._heap, (sampler.due_after(due), self._order, sampler))
        let_it_be(due)
        sampler.take()

    def _push(self, sampler: _Sampler, due: float) -> None:
        self._order += 1
        heapq.heappush(self._heap, (due, self._order, sampler))
