"""The display of a running simulator on stderr: a table of its robots on a terminal, a log elsewhere."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

from hmrsim.actions import registry as actions
from hmrsim.cli.event_log import BufferedSink, EventLog, LogLines, summary
from hmrsim.cli.worlds import policy_line
from hmrsim.errors import printable
from hmrsim.events import Severity

if TYPE_CHECKING:
    from hmrsim.protocol.sinks import Sink
    from hmrsim_zenoh.hosting.host import Host

_log = logging.getLogger(__name__)


class TableDisplay:
    """A table of robots, with log lines above it."""

    def __init__(self, world: str, level: int) -> None:
        # Slow to import, and needed on a terminal only.
        from hmrsim.cli.run_table import LastGoals

        self._world = world
        self._level = level
        self._goals = LastGoals()
        self.sinks: Sequence[Sink] = (self._goals, EventLog(Severity.WARNING, goals=False))
        self.on_wait: Sequence[Callable[[], None]] = ()
        self.preparations: Iterable[object] = ()

    @contextmanager
    def shown(self, host: Host) -> Iterator[Callable[[], None]]:
        """Show the table, which is refreshed periodically."""
        from hmrsim.cli.run_table import HostTable

        with HostTable(host, self._world, self._goals) as table, LogLines(table.print, self._level):
            _log_policy(host)
            yield table.refresh


class LogDisplay:
    """Log lines."""

    def __init__(self, world: str, level: int) -> None:
        self._world = printable(world)
        self._level = level
        told = level <= logging.INFO
        self._events = BufferedSink(EventLog())
        self.sinks: Sequence[Sink] = (self._events,)
        self.on_wait: Sequence[Callable[[], None]] = (self._events.forward,)
        self.preparations: Iterable[object] = (summary(action.goal()) for action in actions().values()) if told else ()

    @contextmanager
    def shown(self, host: Host) -> Iterator[Callable[[], None]]:
        """Write the lines; nothing is refreshed."""
        with LogLines(level=self._level):
            _log.info("sim %.3f | %s begins", host.simulator.now, self._world)
            _log_policy(host)
            if awaited := host.pacing.state.waiting_for:
                _log.info("sim %.3f | time stands, waiting for %s", host.simulator.now, ", ".join(awaited))
            yield lambda: None
            self._events.forward()
            _log.info("sim %.3f | %s ends", host.simulator.now, self._world)


def _log_policy(host: Host) -> None:
    """Log the traffic policy in force."""
    if policy := policy_line(host.simulator.world):
        _log.info("sim %.3f | %s", host.simulator.now, policy)


def display(world: str, level: int, *, on_terminal: bool) -> TableDisplay | LogDisplay:
    """Return the display of a run."""
    return TableDisplay(world, level) if on_terminal else LogDisplay(world, level)
