"""The sink that records a run to a file, and its message when the file is complete."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TYPE_CHECKING

from hmrsim.cli.output import warn
from hmrsim.cli.rosout import told
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.time import LOCKSTEP
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.sink import RecordingSink
from hmrsim_zenoh.recording.writing import RecordingFile

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.protocol.sinks import Sink
    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing
    from hmrsim_zenoh.hosting.served_simulation import Watchers


@contextmanager
def recorded(path: Path, settings: RunSettings) -> Iterator[Watchers]:
    """Return a factory of the sink that records a run to a file, which is complete after the context."""
    made: list[tuple[RecordingFile, Recorder, RecordingSink]] = []
    with ExitStack() as files:

        def watchers(simulator: Simulator, pacing: Pacing) -> Sequence[Sink]:
            file = files.enter_context(RecordingFile(path, reproducible=settings.clock == LOCKSTEP))
            recorder = Recorder(file, told)
            sink = RecordingSink(simulator, recorder, lambda: pacing.state, clock_rate=settings.clock_rate)
            made.append((file, recorder, sink))
            warn(f"recording to {path}")
            return (sink,)

        yield watchers
        for _file, _recorder, sink in made:
            sink.close()
    for file, recorder, _sink in made:
        warn(account(path, file, recorder))


def account(path: Path, file: RecordingFile, recorder: Recorder) -> str:
    """Return how much was recorded, as text."""
    seconds = (recorder.time.now - recorder.time.begin) / NANOSECONDS
    found = f"recorded {seconds:.1f} s: {file.messages} messages"
    try:
        size = path.stat().st_size
    except OSError:
        return f"{found}, but {path} is no longer there: it was deleted or moved meanwhile"
    return f"{found}, {size / 1e6:.1f} MB in {path}"
