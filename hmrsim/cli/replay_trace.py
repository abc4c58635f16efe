"""What ``hmrsim replay`` does: it runs a trace again, and compares."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from hmrsim import __version__
from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json, warn
from hmrsim.cli.trace_file import errors_of, lines_of
from hmrsim.errors import printable
from hmrsim.program.log_options import logging_to_stderr
from hmrsim.program.memory import collect_rarely
from hmrsim.trace.replay import Difference, Outcome, Replayed, replay
from hmrsim.trace.sections import check_section, restart_text

if TYPE_CHECKING:
    from pathlib import Path


def run_again(args: argparse.Namespace) -> int:
    """Run a trace again, and report whether the result is the same; return the exit code."""
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
    if args.json:
        show_json(_described(outcome))
    else:
        _show(args.trace, outcome, args.section)
    return ExitCode.DONE if outcome.difference is None else ExitCode.FAILED


def _described(outcome: Outcome) -> dict[str, Any]:
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


def _show(path: Path, outcome: Outcome, wanted: int | None) -> None:
    if len(outcome.sections) > 1:
        for section in outcome.sections:
            if wanted in (None, section.header.section):
                show(_told(section))
    if outcome.difference is not None:
        _show_difference(path, outcome.difference)
        return
    cut = "" if outcome.complete else "; the trace is truncated there"
    until = "" if wanted is None or cut else f", up to the end of section {wanted}"
    show(f"identical: {_amount(outcome)}{until}{cut}")


def _told(section: Replayed) -> str:
    header = section.header
    why = f": {restart_text(header.cause)}" if header.cause else ""
    return printable(f"section {header.section}, {header.name}, seed {header.seed}, {_amount(section)}{why}")


def _amount(what: Outcome | Replayed) -> str:
    return f"{what.lines} lines, {what.commands} commands, {what.sim_time:.3f} simulated seconds"


def _show_difference(path: Path, difference: Difference) -> None:
    """Print both lines, and those around them."""
    number = difference.line
    show(f"{path}:{number}: the replay differs here")
    rows = [(number - len(difference.before) + i, " ", line) for i, line in enumerate(difference.before)]
    rows.append((number, "-", difference.trace))
    rows.append((number, "+", difference.replay or "(nothing happens any more)"))
    rows += [(number + 1 + i, " ", line) for i, line in enumerate(difference.after)]
    width = len(str(rows[-1][0]))
    for at, sign, line in rows:
        show(f"{sign} {at:{width}}  {printable(line)}")
    show("- the trace, + the replay")
