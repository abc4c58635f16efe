"""The messages of events on a recording's ``/rosout``."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from hmrsim.cli.event_log import text_of
from hmrsim.errors import printable
from hmrsim.events import Severity
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim_zenoh.recording.recorder import Told

if TYPE_CHECKING:
    from hmrsim.events import Event

_WORLD: Final = "world"
"""The name on lines about no robot, door or other part of the world."""

_LEVELS: Final[Mapping[Severity, int]] = {
    Severity.INFO: Log.INFO,
    Severity.WARNING: Log.WARN,
    Severity.ERROR: Log.ERROR,
}


def told(event: Event) -> Told | None:
    """Return the line about an event; None if it has none."""
    text = text_of(event)
    return Told(_LEVELS[event.severity], event.subject or _WORLD, printable(text)) if text else None
