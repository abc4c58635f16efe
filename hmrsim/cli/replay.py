"""``hmrsim replay``: run a trace again, and report whether the result is the same."""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.options import add_json, count
from hmrsim.cli.output import show_result, warn
from hmrsim.errors import printable
from hmrsim.program.log_options import add_log_options, logging_to_stderr

if TYPE_CHECKING:
    from hmrsim.trace.replay import Difference, Outcome, Replayed


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
    from hmrsim.cli.trace_file import errors_of, lines_of
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
    return {
        "identical": outcome.difference is None,
        "complete": outcome.complete,
        "lines": outcome.lines,
        "commands": outcome.commands,
        "sim_time": outcome.sim_time,
        "world": {"name": outcome.header.name, "hash": outcome.header.hash},
        "seed": outcome.header.seed,
        "difference": None if outcome.difference is None else asdict(outcome.difference),
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
    rows.append((number, "-", difference.trace))
    rows.append((number, "+", difference.replay or "(nothing happens any more)"))
    rows += [(number + 1 + i, " ", line) for i, line in enumerate(difference.after)]
    width = len(str(rows[-1][0]))
    for at, sign, line in rows:
        yield f"{sign} {at:{width}}  {printable(line)}"
    yield "- the trace, + the replay"
