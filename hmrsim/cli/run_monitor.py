"""Watching over the properties of a run while it is served."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Final

from hmrsim.cli.worlds import show_findings
from hmrsim.engine.sim_time import stamp
from hmrsim.events.simulation import PropertyViolated
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.properties import Ended, Monitor, MonitorSink, check_properties, read_properties
from hmrsim.protocol.outputs import EventStamped

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.properties import Violation
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World

_log = logging.getLogger(__name__)

_STOPPED: Final = Ended("stopped")


class RunMonitor:
    """Watches over the properties of a file, and publishes each violation as an event of the world.

    Args:
        path: The file.

    Raises:
        PropertyError: It is not valid, or speaks of what the world lacks.
    """

    def __init__(self, path: Path, world: World) -> None:
        self._simulator: Simulator | None = None
        self._running = True
        properties = read_properties(path)
        show_findings(properties, check_properties(properties, world))
        self._monitor = Monitor(properties, world)

    @property
    def violated(self) -> bool:
        """Whether a property was violated."""
        return bool(self._monitor.violations)

    def sink(self, simulator: Simulator) -> MonitorSink:
        """Return the sink that watches; it comes after all others, which have an event before its violations."""
        self._simulator = simulator
        return MonitorSink(simulator, self._monitor, self._tell)

    def end(self, at: float) -> None:
        """Take the end of the run, which says nothing of what might still have come."""
        self._running = False
        self._monitor.end(stamp(at), _STOPPED)

    def _tell(self, violation: Violation) -> None:
        simulator = self._simulator
        at = violation.at / NANOSECONDS
        event = PropertyViolated(violation.property, violation.subject, at, violation.reason, violation.text)
        if simulator is not None and self._running:
            simulator.publisher.emit(EventStamped(stamp(simulator.now), event))
        else:
            _log.error("sim %.3f | %s", at, event.describe())
