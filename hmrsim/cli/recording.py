"""Recordings: the sink that records a run, and the messages of events on ``/rosout``."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING, Final

from hmrsim.cli.event_log import text_of
from hmrsim.cli.output import warn
from hmrsim.errors import printable
from hmrsim.events import Severity
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim.protocol.time import LOCKSTEP
from hmrsim_zenoh.recording.recorder import LogLine, Recorder
from hmrsim_zenoh.recording.sink import RecordingSink
from hmrsim_zenoh.recording.writer import RecordingFile

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.events import Event
    from hmrsim.protocol.sinks import Sink
    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing
    from hmrsim_zenoh.hosting.served_simulation import Watchers

_WORLD: Final = "world"
"""The name on messages about the world as a whole."""

_LEVELS: Final[Mapping[Severity, int]] = {
    Severity.INFO: Log.INFO,
    Severity.WARNING: Log.WARN,
    Severity.ERROR: Log.ERROR,
}


def rosout(event: Event) -> LogLine | None:
    """Return the message about an event; None for events that are too frequent for a log."""
    text = text_of(event)
    return LogLine(_LEVELS[event.severity], event.subject or _WORLD, printable(text)) if text else None


@contextmanager
def recorded(path: Path, settings: RunSettings) -> Iterator[Watchers]:
    """Return a factory of the sink that records a run to a file; the file is complete after the context."""
    recordings: list[tuple[RecordingFile, Recorder, RecordingSink]] = []
    with ExitStack() as files:

        def watchers(simulator: Simulator, pacing: Pacing) -> Sequence[Sink]:
            file = files.enter_context(RecordingFile(path, reproducible=settings.clock == LOCKSTEP))
            recorder = Recorder(file, rosout)
            sink = RecordingSink(simulator, recorder, lambda: pacing.state, clock_rate=settings.clock_rate)
            recordings.append((file, recorder, sink))
            warn(f"recording to {path}")
            return (sink,)

        yield watchers
        for _file, _recorder, sink in recordings:
            sink.close()
    for file, recorder, _sink in recordings:
        warn(summary(path, file, recorder))


def summary(path: Path, file: RecordingFile, recorder: Recorder) -> str:
    """Return a line about how much was recorded."""
    seconds = (recorder.time.now - recorder.time.begin) / NANOSECONDS
    text = f"recorded {seconds:.1f} s: {file.messages} messages"
    try:
        size = path.stat().st_size
    except OSError:
        return f"{text}, but {path} is no longer there: it was deleted or moved meanwhile"
    return f"{text}, {size / 1e6:.1f} MB in {path}"
