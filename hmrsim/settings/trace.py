"""The setting that says where the trace of a run goes."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from hmrsim.settings.model import Settings
from hmrsim.settings.option import Option


class TraceSettings(Settings):
    """Whether a run is traced."""

    trace: Annotated[Path | None, Option("write a trace of the run as lines of JSON, for `hmrsim replay`", "FILE")] = (
        None
    )
