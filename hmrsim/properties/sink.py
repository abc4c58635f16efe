"""A monitor of a simulation that runs: a sink that gives it what it asks for, and computes no more."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hmrsim.engine.sim_time import stamp
from hmrsim.events.simulation import PropertyViolated, SimulationReset, WorldLoaded
from hmrsim.properties.observing.timeline import GoalSeen
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.outputs import EventStamped, GoalChanged, TimeRestarted
from hmrsim.protocol.topics import Topic
from hmrsim.report.occurrence import BatterySeen, Occurrence, SceneSeen
from hmrsim.simulation.snapshot import scene

if TYPE_CHECKING:
    from hmrsim.properties.monitor import Monitor
    from hmrsim.properties.results import Violation
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator


class MonitorSink:
    """A sink that feeds a monitor.

    Args:
        simulator: The simulator; it has not started.
        on_violation: Called with each violation as soon as it is found, in the thread of the simulation.
    """

    def __init__(
        self,
        simulator: Simulator,
        monitor: Monitor,
        on_violation: Callable[[Violation], object] = lambda _violation: None,
    ) -> None:
        self._simulator = simulator
        self._monitor = monitor
        self._handlers = monitor.timeline.handlers
        self._motion = monitor.wants_motion
        self._weighed = -1
        self._statuses = monitor.wants_status
        monitor.listen(on_violation)
        now = stamp(simulator.now)
        monitor.begin(now)
        self._powered = monitor.powered
        if simulator.now:
            # What a world begins with is known.
            self._see(now)

    def wants(self, topic: Topic) -> bool:
        """Return whether it wants a topic: events, and motions if a property speaks of what robots do."""
        return topic is Topic.EVENTS or (self._motion and topic is Topic.MOTION)

    def emit(self, output: Output) -> None:
        """Pass on what the monitor wants."""
        if take := self.taker(type(output)):
            take(output)

    def taker(self, kind: type) -> Callable[[Any], object] | None:
        """Return what takes outputs of a type."""
        takers: dict[type, Callable[[Any], object]] = {
            EventStamped: self._take,
            GoalChanged: self._change,
            TimeRestarted: self._restart,
        }
        return takers.get(kind)

    def weigh(self) -> None:
        """Pass on the charge of the batteries that are asked for, as at the end of a run."""
        self._weigh(stamp(self._simulator.now))

    def _take(self, output: EventStamped) -> None:
        event = output.event
        if isinstance(event, PropertyViolated):
            # It is told in the middle of an instant, in which time must not go on.
            return
        handlers = self._handlers.get(type(event))
        if handlers is None:
            self._monitor.timeline.look(output.stamp)
            return
        self._weigh(output.stamp)
        self._monitor.timeline.give(output.stamp, event, handlers)
        if isinstance(event, SimulationReset | WorldLoaded):
            self._see(output.stamp)

    def _restart(self, output: TimeRestarted) -> None:
        self._monitor.timeline.restart(output.ended)

    def _change(self, change: GoalChanged) -> None:
        at, robot, action, goal_id, status, asked, _, cause = change
        self._weigh(at)
        if self._statuses:
            if asked is not None:
                self._monitor.request(robot, action, asked)
            self._monitor.take(Occurrence(at, change.event()))
        else:
            self._monitor.goal(at, GoalSeen(robot, action, goal_id, int(status), cause), asked)

    def _see(self, at: int) -> None:
        if self._monitor.wants_scene:
            self._monitor.take(Occurrence(at, SceneSeen(scene(self._simulator))))

    def _weigh(self, at: int) -> None:
        """Pass on the charge of the batteries that are asked for, once an instant."""
        if not self._powered or at == self._weighed:
            return
        self._weighed = at
        for name in [*self._powered]:
            robot = self._simulator.robots.get(name)
            if robot is not None and robot.energy is not None:
                self._monitor.take(Occurrence(at, BatterySeen(name, robot.energy.battery.share(robot.now))))

    def commanded(self, command: Command, _by: str, _now: float) -> None:
        """Take note of what a goal asks for, as it may be rejected."""
        if isinstance(command, SendGoal):
            self._monitor.request(command.robot, command.action, command.goal)
