"""Writing the trace of a run to the file of ``--trace``."""

from __future__ import annotations

from contextlib import contextmanager, suppress
from typing import IO, TYPE_CHECKING

from hmrsim.errors import HmrsimError, TraceError, reason_of
from hmrsim.trace.writer import Trace

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path

    from hmrsim.simulation.simulator import Simulator


def check_writable(path: Path | None) -> None:
    """Do nothing if a trace can be written there, or none is wanted.

    Raises:
        TraceError: It can't.
    """
    if path is not None:
        _opened(path).close()


def _opened(path: Path) -> IO[str]:
    try:
        return path.open("w", encoding="ascii", newline="\n")
    except OSError as error:
        raise TraceError(f"--trace {path}: can't be written: {reason_of(error)}") from None


@contextmanager
def told_of(path: Path, *, no_text: str) -> Iterator[None]:
    """Have whatever is wrong with a file that is read within told with its path.

    Args:
        path: The file.
        no_text: What is said of one that is no text.

    Raises:
        TraceError: It can't be read, or makes no sense.
    """
    try:
        yield
    except OSError as error:
        raise TraceError(f"{path}: can't be read: {reason_of(error)}") from None
    except UnicodeDecodeError:
        raise TraceError(f"{path}: {no_text}") from None
    except TraceError as error:
        raise TraceError(f"{path}: {error}") from None


@contextmanager
def traced(path: Path | None, simulator: Simulator) -> Iterator[Trace | None]:
    """Write the trace of a run to a file, if one is wanted; complete at the end of the context.

    Raises:
        TraceError: The file can't be written.
    """
    if path is None:
        yield None
        return
    with _opened(path) as file:

        def write(text: str) -> None:
            # Whole lines, and at once: whoever looks, or comes after a crash, finds them.
            file.write(text)
            file.flush()

        trace = Trace(simulator, write)
        trace.flush()
        try:
            yield trace
        except BaseException:
            # What broke the run may be that nothing can be written.
            with suppress(HmrsimError):
                trace.flush()
            raise
        trace.close()
