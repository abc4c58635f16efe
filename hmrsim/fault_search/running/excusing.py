"""A monitor's sink that is not told of what a disturbance does on purpose."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.events.simulation import ParticipantDropped
from hmrsim.properties import MonitorSink

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import EventStamped


class ExcusingSink(MonitorSink):
    """A monitor's sink to which a controller that is cut off on purpose is not dropped: it is no failure of its own."""

    def _take(self, output: EventStamped) -> None:
        """Pass on what the monitor wants, but that a participant is dropped: that leaves its goals to nobody."""
        if isinstance(output.event, ParticipantDropped):
            self._monitor.replace_controller()
        else:
            super()._take(output)
