"""Recording a simulation from inside of its process."""

from __future__ import annotations

import json
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
    from collections.abc import Callable

    from hmrsim.protocol.outputs import Event
    from hmrsim.protocol.time import TimeState
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.recording.recorder import Recorder

_HEARD: Final = frozenset(Topic) - {Topic.TIME}


class RecordingSink:
    """Records what happens, all of it: nothing is thinned out.

    Args:
        simulator: A simulator that has not begun.
        recorder: What writes it down.
        time: Tells how time moves.
        clock_rate: Samples of the clock a simulated second.
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
        """Return whether it takes a topic."""
        return topic in _HEARD

    def emit(self, event: Event) -> None:
        """Write an event."""
        match event:
            case Sampled():
                self._sample(event)
            case GoalChanged():
                self._recorder.event(event.event(), encoding.event_payload(event), event.stamp)
            case EventStamped():
                self._recorder.event(event.event, encoding.event_payload(event), event.stamp)
            case StatusChanged():
                self._recorder.status(event)
            case FeedbackSent():
                self._recorder.feedback(event, stamp(self._simulator.now))

    def close(self) -> None:
        """Write what is still to be told."""
        self._settle(due=self._recorder.stale)
        self._recorder.settle()

    def _sample(self, event: Sampled) -> None:
        now = stamp(self._simulator.now)
        if event.topic is not Topic.CLOCK:
            self._recorder.sample(event, now)
            return
        # The time is told also whenever it stands still, which depends on when who controls the robots answers.
        if now == self._nearest_tick(now) and now != self._clock:
            self._clock = now
            self._recorder.sample(event, now)
        self._settle(due=self._recorder.scene_due)

    def _nearest_tick(self, now: int) -> int:
        """Return when a sample of the clock is due, reckoned as `hmrsim.engine.sampling` does."""
        return round(round(now / NANOSECONDS / self._period) * self._period * NANOSECONDS)

    def _settle(self, *, due: bool) -> None:
        """Tell anew what has changed too much; when nothing else is being done."""
        if self._recorder.world_stale:
            self._description.forget()
            self._recorder.tell_anew(*self._now())
        elif due:
            self._recorder.scene(scene(self._simulator))

    def _now(self) -> tuple[dict[str, Any], dict[str, Any], dict[str, Any]]:
        simulator = self._simulator
        return native_data(simulator.world), json.loads(self._description.info()), scene(simulator)
