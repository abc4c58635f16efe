"""Recording a run to the file of ``--record``."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from hmrsim.cli.output import warn
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.protocol.time import LOCKSTEP

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator

    from hmrsim_zenoh.host import Host
    from hmrsim_zenoh.recording.recorder import Recorder
    from hmrsim_zenoh.recording.writing import RecordingFile


def add_record_option(parser: argparse.ArgumentParser) -> None:
    """Give a command what `recorded` is told."""
    parser.add_argument(
        "--record", type=Path, metavar="FILE.mcap", help="record all that is published, for Foxglove and `hmrsim view`"
    )


@contextmanager
def recorded(path: Path | None, host: Host, *, clock_rate: float) -> Iterator[None]:
    """Record a run to a file, if that is wanted; complete at the end of the context.

    Raises:
        RecordingError: The file can't be opened.
    """
    if path is None:
        yield
        return
    # Takes its time to load, which no other run needs.
    from hmrsim.cli.rosout import told  # noqa: PLC0415
    from hmrsim_zenoh.recording.recorder import Recorder  # noqa: PLC0415
    from hmrsim_zenoh.recording.sink import RecordingSink  # noqa: PLC0415
    from hmrsim_zenoh.recording.writing import RecordingFile  # noqa: PLC0415

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
