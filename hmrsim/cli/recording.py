"""Recording a run to the file of ``--record``."""

from __future__ import annotations

from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Sequence
    from pathlib import Path

    from hmrsim.protocol.sinks import Sink
    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing


@contextmanager
def recording(path: Path | None, settings: RunSettings) -> Iterator[Callable[[Simulator, Pacing], Sequence[Sink]]]:
    """Return a factory of the sink that records a run, if a path is given; the file is complete after the context.

    Args:
        path: The file; None for no recording. It is opened when the sink is made, which raises RecordingError if that
            fails.
        settings: Of the run.
    """
    if path is None:
        yield lambda _simulator, _pacing: ()
        return
    # Loads the MCAP writer, which takes 100 ms and is needed for recorded runs only.
    from hmrsim.cli.run_recording import recorded  # noqa: PLC0415

    with recorded(path, settings) as watchers:
        yield watchers
