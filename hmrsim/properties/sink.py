"""A monitor of a simulation that runs: a sink that gives it what it asks for, and computes no more."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from hmrsim.properties.observing.timeline import GoalSeen
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.outputs import EventStamped, GoalChanged, TimeRestarted
from hmrsim.protocol.topics import Topic

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
        monitor.listen(on_violation)

    def wants(self, topic: Topic) -> bool:
        """Return whether it wants a topic: events, and motions if a property speaks of where robots are."""
        return topic is Topic.EVENTS

    def emit(self, output: Output) -> None:
        """Pass on what the monitor wants."""
        if isinstance(output, EventStamped):
            handlers = self._handlers.get(type(output.event))
            if handlers is not None:
                self._monitor.timeline.give(output.stamp, output.event, handlers)
        elif isinstance(output, GoalChanged):
            stamp, robot, action, goal_id, status, asked, _, cause = output
            self._monitor.goal(stamp, GoalSeen(robot, action, goal_id, int(status), cause), asked)
        elif isinstance(output, TimeRestarted):
            self._monitor.timeline.restart(output.ended)

    def commanded(self, command: Command, _by: str, _now: float) -> None:
        """Take note of what a goal asks for, as it may be rejected."""
        if isinstance(command, SendGoal):
            self._monitor.request(command.robot, command.action, command.goal)
