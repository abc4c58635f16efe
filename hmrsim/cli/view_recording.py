"""The recording that ``hmrsim view`` shows; live pictures need not load what reads it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim_zenoh.recording import open_recording
from hmrsim_zenoh.view.recorded import Recorded

if TYPE_CHECKING:
    from pathlib import Path


def recording(path: Path) -> Recorded:
    """Return a recording.

    Raises:
        RecordingError: It is not a recording.
    """
    return Recorded(open_recording(path))
