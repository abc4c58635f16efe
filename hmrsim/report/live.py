"""The report of a simulation of this process, without a trace between."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim.engine.sim_time import stamp
from hmrsim.report.compile import report_of
from hmrsim.report.content import ReportInput, notes_of
from hmrsim.report.model import Source
from hmrsim.report.sink import ReportSink
from hmrsim.report.story import Story
from hmrsim.trace.writer import Header

if TYPE_CHECKING:
    from hmrsim.report.model import Report
    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World


class LiveReport:
    """Follows a simulation, and reports on it at its end.

    Args:
        world: What is run.
        settings: How.
    """

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
        said: dict[str, Any] = {"seed": header.seed, "hmrsim": header.version, "contract": header.contract}
        said["world"] = {"name": header.name, "hash": header.hash}
        source = Source(kind="trace", exact=True, complete=True, notes=tuple(notes_of(self._story)))
        return report_of(ReportInput(self._story, source, said, dict(header.definition)))
