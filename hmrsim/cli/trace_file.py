"""Trace files: reading them, writing them during a run, and comparing a repeated run with one."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import HmrsimError, TraceError, reason_of
from hmrsim.program.files import (
    MAX_VALUES,
    MAX_VALUES_OF_WORLD,
    TextOutput,
    check_regular,
    has_more_values,
)
from hmrsim.trace.sections import may_begin_section
from hmrsim.trace.writer import Header, Trace

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World


_OPTION: Final = "--trace"

_MCAP: Final = b"\x89MCAP"

_MAX_CHARACTERS: Final = 64 * 1024 * 1024
"""Maximum length of a line; worlds are shorter, and all other lines are much shorter."""


def check_writable(path: Path | None) -> None:
    """Check that a trace can be written to *path*, unless it is None.

    Raises:
        OutputError: It can't be written.
    """
    if path is not None:
        TextOutput(_OPTION, path).close()


@contextmanager
def errors_of(path: Path, *, no_text: str) -> Iterator[None]:
    """Add the path to errors of reading a file within the context.

    Args:
        path: The file.
        no_text: The error for a file that is not text.

    Raises:
        TraceError: The file can't be read, or its content is invalid.
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
    """Return whether a file is a recording (MCAP) rather than a trace.

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
    """The file of a run's trace.

    Args:
        path: The file; None for no trace.

    Attributes:
        sinks: The sink to pass to the simulator; empty for no trace.
    """

    def __init__(self, path: Path | None, world: World, settings: RunSettings) -> None:
        self._path = path
        self._file: TextOutput | None = None
        self._complete = False
        # The header contains the world, which takes seconds to write if it is large.
        self.sinks: tuple[Trace, ...] = () if path is None else (Trace(Header.of(world, settings), self._write),)

    @contextmanager
    def opened(self, simulator: Simulator) -> Iterator[None]:
        """Write the trace of a simulator until the end of the context, when it is complete.

        Raises:
            OutputError: The file can't be opened.
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
            # Outputs of processes that Python frees after the run do not belong to it.
            return
        if self._file is None:
            raise AssertionError
        # Whole lines are flushed at once, so that they can be read during the run and after a crash.
        self._file.write(text)


_MOST_REPEATS: Final = 4
_SEED: Final = "PYTHONHASHSEED"


def difference_from(kept: str, now: str, repeat: Callable[..., str], *args: Any) -> str:
    """Return where a repeated run first differs, as text.

    Args:
        kept: The trace of the original run; empty if it was not kept. Then the run is repeated in other processes
            until one of them differs.
        now: The trace of the repeated run.
        repeat: Repeats the run and returns its trace, in another process.
        args: The arguments of *repeat*.
    """
    from hmrsim.trace.difference import first_difference

    if kept:
        difference = first_difference(kept, now)
        return difference.describe() if difference else "the trace is the same"
    for other in _in_new_processes(repeat, *args):
        if difference := first_difference(other, now):
            return f"two runs of now differ, too: the controller is not deterministic; {difference.describe()}"
    return (
        f"{_MOST_REPEATS} more runs are all as this one: the code of the controller, or something that it reads, "
        "has changed since"
    )


def _in_new_processes(repeat: Callable[..., str], *args: Any) -> Iterator[str]:
    """Yield the results of calling a function in new processes, each with a different hash seed."""
    import multiprocessing
    from concurrent.futures import ProcessPoolExecutor

    before = os.environ.get(_SEED)
    try:
        for number in range(_MOST_REPEATS):
            os.environ[_SEED] = str(number + 1)
            with ProcessPoolExecutor(1, mp_context=multiprocessing.get_context("spawn")) as process:
                yield process.submit(repeat, *args).result()
    finally:
        os.environ.pop(_SEED, None)
        if before is not None:
            os.environ[_SEED] = before
