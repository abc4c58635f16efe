"""``hmrsim replay``: run a trace again, and report whether the result is the same; and the trace files of commands."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, add_json, count
from hmrsim.cli.output import show_result, warn
from hmrsim.errors import HmrsimError, TraceError, printable, reason_of
from hmrsim.program.files import MAX_VALUES, MAX_VALUES_OF_WORLD, TextOutput, check_regular, has_more_values
from hmrsim.program.log_options import add_log_options, logging_to_stderr
from hmrsim.trace.sections import may_begin_section
from hmrsim.trace.writer import Header, Trace

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.settings.run import RunSettings
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.trace.difference import Difference
    from hmrsim.trace.replay import Outcome, Replayed
    from hmrsim.world.model import World


_OPTION: Final = "--trace"

_MCAP: Final = b"\x89MCAP"

_MAX_CHARACTERS: Final = 64 * 1024 * 1024
"""Maximum length of a line; worlds are shorter, and all other lines are much shorter."""


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


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim replay``."""
    parser.description = (
        "Run a trace again without any network or controller, and report whether it is identical,\n"
        "or where it first differs. A truncated trace is run to its end."
    )
    parser.epilog = """\
A trace has a section for each time that a client restarted the simulation. All sections are repeated, since each
starts from the state that the sections before it left; --section N ends after that one.

exit codes: 0 the replay is identical, byte for byte; 1 it is not; 2 the file is not a trace, or has no such section

examples:
  hmrsim replay run.jsonl
  hmrsim replay run.jsonl --section 2
  hmrsim replay run.jsonl --json | jq .difference"""
    parser.add_argument("trace", type=Path, metavar="TRACE", help="a file written by --trace")
    parser.add_argument("--section", type=count, metavar="N", help="stop after this section (default: all)")
    add_json(parser, "print the outcome as one JSON object")
    add_log_options(parser, default="error")
    parser.set_defaults(function=_replay)


def _replay(args: argparse.Namespace) -> int:
    from hmrsim import __version__
    from hmrsim.program.memory import collect_rarely
    from hmrsim.trace.replay import replay
    from hmrsim.trace.sections import check_section

    collect_rarely()
    with (
        errors_of(args.trace, no_text="is not a trace: it is not text"),
        logging_to_stderr(args),
    ):
        if args.section is not None:
            check_section(lines_of(args.trace), args.section)
        outcome = replay(lines_of(args.trace), section=args.section)
    if outcome.header.version != __version__:
        warn(f"{args.trace} was written by hmrsim {outcome.header.version}; this is {__version__}")
    show_result(_facts(outcome), _lines(args.trace, outcome, args.section), as_json=args.json)
    return ExitCode.DONE if outcome.difference is None else ExitCode.FAILED


def _facts(outcome: Outcome) -> dict[str, Any]:
    found = outcome.difference
    return {
        "identical": found is None,
        "complete": outcome.complete,
        "lines": outcome.lines,
        "commands": outcome.commands,
        "sim_time": outcome.sim_time,
        "world": {"name": outcome.header.name, "hash": outcome.header.hash},
        "seed": outcome.header.seed,
        "difference": found
        and {
            "line": found.line,
            "trace": found.was,
            "replay": found.now,
            "before": found.before,
            "after": found.after,
        },
        **({"sections": [_section(section) for section in outcome.sections]} if len(outcome.sections) > 1 else {}),
    }


def _section(section: Replayed) -> dict[str, Any]:
    header = section.header
    return {
        "number": header.section,
        "cause": header.cause,
        "world": {"name": header.name, "hash": header.hash},
        "seed": header.seed,
        "lines": section.lines,
        "commands": section.commands,
        "sim_time": section.sim_time,
    }


def _lines(path: Path, outcome: Outcome, number: int | None) -> Iterator[str]:
    from hmrsim.trace.sections import restart_text

    for section in outcome.sections if len(outcome.sections) > 1 else ():
        header = section.header
        if number in (None, header.section):
            cause = f": {restart_text(header.cause)}" if header.cause else ""
            facts = f"section {header.section}, {header.name}, seed {header.seed}, {_amount(section)}"
            yield printable(f"{facts}{cause}")
    if outcome.difference is not None:
        yield from _difference_lines(path, outcome.difference)
        return
    cut = "" if outcome.complete else "; the trace is truncated there"
    until = "" if number is None or cut else f", up to the end of section {number}"
    yield f"identical: {_amount(outcome)}{until}{cut}"


def _amount(replayed: Outcome | Replayed) -> str:
    return f"{replayed.lines} lines, {replayed.commands} commands, {replayed.sim_time:.3f} simulated seconds"


def _difference_lines(path: Path, difference: Difference) -> Iterator[str]:
    """Yield the two lines that differ, with the lines around them."""
    number = difference.line
    yield f"{path}:{number}: the replay differs here"
    rows = [(number - len(difference.before) + i, " ", line) for i, line in enumerate(difference.before)]
    rows.append((number, "-", difference.was or ""))
    rows.append((number, "+", difference.now or "(nothing happens any more)"))
    rows += [(number + 1 + i, " ", line) for i, line in enumerate(difference.after)]
    width = len(str(rows[-1][0]))
    for at, sign, line in rows:
        yield f"{sign} {at:{width}}  {printable(line)}"
    yield "- the trace, + the replay"
