"""Writing the trace of a run to the file of ``--trace``."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Final

from hmrsim.errors import HmrsimError, TraceError, reason_of
from hmrsim.program.inputs import MAX_VALUES, MAX_VALUES_OF_WORLD, check_regular, has_more_values
from hmrsim.program.outputs import TextOutput, check_outputs
from hmrsim.trace.sections import may_begin_section
from hmrsim.trace.writer import Header, Trace

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World


_OPTION: Final = "--trace"

_MCAP: Final = b"\x89MCAP"

_MAX_CHARACTERS: Final = 64 * 1024 * 1024
"""Maximum length of a line; a world takes less, and all other lines much less."""


def check_writable(path: Path | None, inputs: Sequence[Path]) -> None:
    """Check that a trace can be written there, if one is wanted; *inputs* are the files that are read.

    Raises:
        OutputError: It can't.
    """
    check_outputs([(_OPTION, path)], inputs)
    if path is not None:
        TextOutput(_OPTION, path).close()


@contextmanager
def errors_of(path: Path, *, no_text: str) -> Iterator[None]:
    """Raise errors of the file that is read in this context with its path.

    Args:
        path: The file.
        no_text: The error of a file that is not text.

    Raises:
        TraceError: It can't be read, or its content is invalid.
    """
    try:
        yield
    except OSError as error:
        raise TraceError(f"{path}: can't be read: {reason_of(error)}") from None
    except UnicodeDecodeError:
        raise TraceError(f"{path}: {no_text}") from None
    except TraceError as error:
        raise TraceError(f"{path}: {error}") from None


def is_recording(path: Path) -> bool:
    """Return whether a file is a recording (MCAP), and so no trace.

    Raises:
        OSError: It can't be read.
    """
    check_regular(path)
    with path.open("rb") as file:
        return file.read(len(_MCAP)) == _MCAP


def lines_of(path: Path) -> Iterator[str]:
    """Yield the lines of a trace.

    Raises:
        TraceError: A line is too long, or has too many values.
    """
    check_regular(path)
    with path.open(encoding="utf-8", newline="\n") as file:
        for number, line in enumerate(iter(lambda: file.readline(_MAX_CHARACTERS + 1), ""), 1):
            if len(line) > _MAX_CHARACTERS:
                raise TraceError(f"line {number} has more than {_MAX_CHARACTERS} characters")
            most = MAX_VALUES_OF_WORLD if number == 1 or may_begin_section(line) else MAX_VALUES
            if has_more_values(line, most):
                raise TraceError(f"line {number} has more than {most} values")
            yield line


class TraceFile:
    """The trace of a run in a file, if one is wanted.

    Args:
        path: The file; None for no trace.

    Attributes:
        sinks: The trace, to be given to the simulator; nothing if none is wanted.
    """

    def __init__(self, path: Path | None, world: World, settings: RunSettings) -> None:
        self._path = path
        self._file: TextOutput | None = None
        self._complete = False
        # The header has all of the world, which takes seconds where that is large.
        self.sinks: tuple[Trace, ...] = () if path is None else (Trace(Header.of(world, settings), self._write),)

    @contextmanager
    def opened(self, simulator: Simulator) -> Iterator[None]:
        """Write the trace of what a simulator does from here to the end of the context, where it is complete.

        Raises:
            OutputError: It is no file to write to.
            WriteError: The disk is full.
        """
        if self._path is None:
            yield
            return
        (trace,) = self.sinks
        with TextOutput(_OPTION, self._path) as self._file:
            self.flush()
            try:
                yield
            except BaseException:
                # The run may have failed because the trace can't be written.
                with suppress(HmrsimError):
                    self.flush()
                raise
            trace.close(simulator.now)
            self._complete = True

    def flush(self) -> None:
        """Write the buffered lines."""
        for trace in self.sinks:
            trace.flush()

    def _write(self, text: str) -> None:
        if self._complete:
            # What robots do when Python frees their processes is no part of the run.
            return
        if self._file is None:
            raise AssertionError
        # Whole lines, flushed at once, so that a reader finds them during the run and after a crash.
        self._file.write(text)
