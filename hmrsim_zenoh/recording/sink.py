"""The sink that records a simulation in the same process."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

from hmrsim.engine.sim_time import stamp
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.outputs import EventStamped, FeedbackSent, GoalChanged, Sampled, StatusChanged
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.snapshot import scene
from hmrsim.world.writing import native_data
from hmrsim_zenoh.server.world_info import Description
from hmrsim_zenoh.wire import encoding

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output
    from hmrsim.protocol.time import TimeState
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.recording.recorder import Recorder

_TOPICS: Final = frozenset(Topic) - {Topic.TIME}


class RecordingSink:
    """Records everything that a simulation publishes, without a rate limit.

    Args:
        simulator: A simulator that has not started.
        recorder: Writes the recording.
        time: Returns the state of time for the description of the world.
        clock_rate: Samples of the clock per simulated second.
    """

    def __init__(
        self, simulator: Simulator, recorder: Recorder, time: Callable[[], TimeState], *, clock_rate: float
    ) -> None:
        self._simulator = simulator
        self._recorder = recorder
        self._description = Description(simulator, time)
        self._period = 1.0 / clock_rate
        self._clock = -1
        recorder.begin(*self._now(), seed=str(simulator.seed))

    def wants(self, topic: Topic) -> bool:
        """Return whether a topic is recorded."""
        return topic in _TOPICS

    def emit(self, output: Output) -> None:
        """Record an output of the simulation."""
        match output:
            case Sampled():
                self._sample(output)
            case GoalChanged():
                self._recorder.event(output.event(), encoding.event_payload(output), output.stamp)
            case EventStamped():
                self._recorder.event(output.event, encoding.event_payload(output), output.stamp)
            case StatusChanged():
                self._recorder.status(output)
            case FeedbackSent():
                self._recorder.feedback(output, stamp(self._simulator.now))

    def close(self) -> None:
        """Write the data that is still pending at the end of the recording."""
        self._settle(due=self._recorder.stale)
        self._recorder.settle()

    def _sample(self, event: Sampled) -> None:
        now = stamp(self._simulator.now)
        if event.topic is not Topic.CLOCK:
            self._recorder.sample(event, now)
            return
        # The clock is also sampled whenever time stops, and when it stops depends on how fast controllers are.
        if now == self._nearest_tick(now) and now != self._clock:
            self._clock = now
            self._recorder.sample(event, now)
        self._settle(due=self._recorder.scene_due)

    def _nearest_tick(self, now: int) -> int:
        """Return the nearest time of a regular clock sample, computed as in `hmrsim.engine.subscriptions`."""
        return round(round(now / NANOSECONDS / self._period) * self._period * NANOSECONDS)

    def _settle(self, *, due: bool) -> None:
        """Write the world again if it is stale, else the scene if it is *due*."""
        if self._recorder.world_stale:
            self._description.forget()
            self._recorder.write_state(*self._now())
        elif due:
            self._recorder.scene(scene(self._simulator))

    def _now(self) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        simulator = self._simulator
        return native_data(simulator.world), json.loads(self._description.info()), scene(simulator)
