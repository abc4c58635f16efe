"""Recording a simulation for a report: a sink that receives events and reads batteries, and the report of it."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from hmrsim.engine.sim_time import stamp
from hmrsim.events.robots import RouteTaken
from hmrsim.events.simulation import SimulationReset, WorldLoaded
from hmrsim.history.occurrence import BatterySeen, Commanded, Occurrence, SceneSeen
from hmrsim.protocol.commands import CallService
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import EventStamped, GoalChanged, TimeRestarted
from hmrsim.protocol.sinks import SelectiveSink
from hmrsim.protocol.topics import Topic
from hmrsim.report.compile import ReportInput, notes_of, report_of
from hmrsim.report.model import Source
from hmrsim.report.story import Story
from hmrsim.simulation.snapshot import scene
from hmrsim.trace.writer import Header

if TYPE_CHECKING:
    from hmrsim.protocol.commands import Command
    from hmrsim.protocol.outputs import Output
    from hmrsim.report.model import Report
    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World


class ReportSink(SelectiveSink):
    """A sink that passes on occurrences, beginning with the initial state.

    Args:
        restarted: Called when time has begun anew, with the time until then, in nanoseconds.
    """

    topics = frozenset({Topic.EVENTS, Topic.MOTION})

    def __init__(
        self,
        simulator: Simulator,
        take: Callable[[Occurrence], object],
        restarted: Callable[[int], object] = lambda _ended: None,
    ) -> None:
        self._simulator = simulator
        self._take = take
        self._restarted = restarted
        self._charges: list[Occurrence] = []
        self._see()

    def handler_for(self, kind: type) -> Callable[[Any], object] | None:
        """Return the function that processes outputs of a type; None to ignore them."""
        return self.emit if kind in (EventStamped, GoalChanged, TimeRestarted) else None

    def emit(self, output: Output) -> None:
        """Pass on an event as an occurrence."""
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
        elif isinstance(output, TimeRestarted):
            for charge in self._charges:
                self._take(charge)
            self._restarted(output.ended)

    def weigh_all(self) -> None:
        """Pass on the charge of all batteries."""
        for charge in self._all_charges():
            self._take(charge)

    def commanded(self, command: Command, _by: str, now: float) -> None:
        """Pass on the time, as the command may reset it."""
        self._take(Occurrence(stamp(now), Commanded()))
        # Batteries are full again before time begins anew.
        self._charges = self._all_charges() if isinstance(command, CallService) else []

    def _see(self) -> None:
        self._take(Occurrence(stamp(self._simulator.now), SceneSeen(scene(self._simulator))))
        self.weigh_all()

    def _weigh(self, name: str) -> None:
        charge = self._charge(name)
        if charge is not None:
            self._take(charge)

    def _all_charges(self) -> list[Occurrence]:
        found = map(self._charge, self._simulator.robots)
        return [charge for charge in found if charge is not None]

    def _charge(self, name: str) -> Occurrence | None:
        """Return the charge of a robot's battery; None if it has none."""
        robot = self._simulator.robots.get(name)
        if robot is None or robot.energy is None:
            return None
        battery, now = robot.energy.battery, robot.now
        return Occurrence(stamp(now), BatterySeen(name, battery.share(now), battery.charge(now)))


class LiveReport:
    """Follows a simulation, and reports on it at its end."""

    def __init__(self, world: World, settings: RunSettings) -> None:
        self._world, self._settings = world, settings
        self._story = Story()
        self._sink: ReportSink | None = None

    def sink(self, simulator: Simulator) -> ReportSink:
        """Return the sink that follows a simulator, which has not started."""
        self._sink = ReportSink(simulator, self._story.take)
        return self._sink

    def report(self, simulator: Simulator) -> Report:
        """Return the report; what comes after is left out."""
        if self._sink is not None:
            self._sink.weigh_all()
        self._story.end(stamp(simulator.now))
        header = Header.of(self._world, self._settings)
        world = {"name": header.name, "hash": header.hash}
        fields = {"seed": header.seed, "hmrsim": header.version, "contract": header.contract, "world": world}
        source = Source(kind="trace", exact=True, complete=True, notes=tuple(notes_of(self._story)))
        return report_of(ReportInput(self._story, source, fields, dict(header.definition)))
