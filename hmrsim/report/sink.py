"""Recording a simulation for a report: a sink that receives the page's events and reads batteries."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from hmrsim.engine.sim_time import stamp
from hmrsim.events.robots import RouteTaken
from hmrsim.events.simulation import SimulationReset, WorldLoaded
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.report.occurrence import BatterySeen, Commanded, Occurrence, SceneSeen
from hmrsim.simulation.snapshot import scene

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.simulation.simulator import Simulator


class ReportSink:
    """A sink that passes on occurrences, beginning with the initial state.

    Args:
        simulator: The simulator; it has not started.
    """

    def __init__(self, simulator: Simulator, take: Callable[[Occurrence], object]) -> None:
        self._simulator = simulator
        self._take = take
        self._see()

    def wants(self, topic: Topic) -> bool:
        """Return whether it wants a topic: events and motions."""
        return topic in (Topic.EVENTS, Topic.MOTION)

    def emit(self, output: Output) -> None:
        """Pass on an event."""
        if isinstance(output, EventStamped):
            what = output.event
            if isinstance(what, RouteTaken):
                return
            self._take(Occurrence(output.stamp, what))
            if isinstance(what, SimulationReset | WorldLoaded):
                self._see()
            # Between two events the charge is monotonic.
            robot = getattr(what, "robot", None)
            if isinstance(robot, str) and what.traced:
                self._weigh(robot)
        elif isinstance(output, GoalChanged):
            self._take(Occurrence(output.stamp, output.event(results_from=GoalStatus.CANCELED)))
            if output.status.terminal:
                self._weigh(output.robot)

    def weigh_all(self) -> None:
        """Pass on the charge of all batteries."""
        for robot in self._simulator.robots:
            self._weigh(robot)

    def commanded(self, _command: Command, _by: str, now: float) -> None:
        """Pass on the time, as the command may reset it."""
        self._take(Occurrence(stamp(now), Commanded()))

    def _see(self) -> None:
        self._take(Occurrence(stamp(self._simulator.now), SceneSeen(scene(self._simulator))))
        self.weigh_all()

    def _weigh(self, name: str) -> None:
        robot = self._simulator.robots.get(name)
        if robot is None or robot.energy is None:
            return
        battery, now = robot.energy.battery, robot.now
        self._take(Occurrence(stamp(now), BatterySeen(name, battery.share(now), battery.charge(now))))
