"""What records a run, or what a simulator publishes, to a file."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

from hmrsim.cli.output import warn
from hmrsim.cli.rosout import told
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.time import LOCKSTEP
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.sink import RecordingSink
from hmrsim_zenoh.recording.writing import RecordingFile

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from hmrsim_zenoh.host import Host


@contextmanager
def recording(path: Path, host: Host, clock_rate: float) -> Iterator[None]:
    """Record a run to a file; complete at the end of the context.

    Raises:
        RecordingError: The file can't be opened.
    """
    pacing = host.pacing
    with RecordingFile(path, reproducible=pacing.clock == LOCKSTEP) as file:
        recorder = Recorder(file, told)
        sink = RecordingSink(host.simulator, recorder, lambda: pacing.state, clock_rate=clock_rate)
        warn(f"recording to {path}")
        yield
        sink.close()
    warn(account(path, file, recorder))


def account(path: Path, file: RecordingFile, recorder: Recorder) -> str:
    """Return how much was recorded, for people."""
    seconds = (recorder.time.now - recorder.time.begin) / NANOSECONDS
    return f"recorded {seconds:.1f} s: {file.messages} messages, {path.stat().st_size / 1e6:.1f} MB in {path}"
