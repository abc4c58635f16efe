"""Recording a run to the file of ``--record``."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import argparse
    from collections.abc import Iterator

    from hmrsim_zenoh.host import Host


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
    # Loads what writes MCAP, which takes 100 ms and serves recorded runs alone.
    from hmrsim.cli.run_recording import recording  # noqa: PLC0415

    with recording(path, host, clock_rate):
        yield
