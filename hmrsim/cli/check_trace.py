"""Which properties hold in the run of a trace, or of a recording."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import columns, show, show_json, warn
from hmrsim.cli.trace_file import errors_of, is_recording, lines_of
from hmrsim.cli.worlds import show_findings
from hmrsim.errors import printable
from hmrsim.interfaces.builtin_interfaces import NANOSECONDS
from hmrsim.program.log_options import logging_to_stderr
from hmrsim.program.memory import collect_rarely
from hmrsim.properties import Properties, check_recording, read_properties
from hmrsim.properties import check_trace as check_lines
from hmrsim_zenoh.recording import open_recording

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.properties import Checked, Verdict, Violation

_MOST: Final = 50
"""Violations that are printed."""
_WORDS: Final = {"never_exercised": "never exercised"}


def check_trace(args: argparse.Namespace) -> int:
    """Check the properties of *args.properties* on the run of *args.trace*; return the exit code.

    It is 0 if none is violated, 1 if one is.

    Raises:
        TraceError: The file is neither a trace nor a recording.
        PropertyError: The properties are not valid, or speak of what the world lacks.
    """
    properties = Properties() if args.properties is None else read_properties(args.properties)
    collect_rarely()
    with logging_to_stderr(args):
        checked = _checked(args.trace, properties)
    for note in checked.notes:
        warn(f"{args.trace}: {printable(note)}")
    monitor = checked.monitor
    if args.json:
        show_json(as_json(checked))
    else:
        show_verdicts(monitor.verdicts())
        show_violations(monitor.violations)
    return ExitCode.FAILED if monitor.violations else ExitCode.DONE


def _checked(path: Path, properties: Properties) -> Checked:
    # What is misspelt is told before a long run is replayed.
    found = partial(show_findings, properties)
    with errors_of(path, no_text="neither a trace (text) nor a recording (MCAP)"):
        if is_recording(path):
            return check_recording(open_recording(path), properties, found)
        return check_lines(lambda: lines_of(path), properties, found)


def as_json(checked: Checked) -> dict[str, Any]:
    """Return what has come of a check, in plain values."""
    monitor = checked.monitor
    return {
        "violated": bool(monitor.violations),
        "verdicts": [verdict.as_dict() for verdict in monitor.verdicts()],
        "violations": [violation.as_dict() for violation in monitor.violations],
        "notes": list(checked.notes),
    }


def show_verdicts(verdicts: Sequence[Verdict]) -> None:
    """Print a line for each property."""
    rows = [("property", "verdict", "robustness", "")]
    for verdict in verdicts:
        robustness = f"{verdict.robustness:+.2f}" if verdict.state in {"holds", "violated"} else ""
        rows.append((verdict.property, _WORDS.get(verdict.state, verdict.state), robustness, verdict.text))
    for line in columns(rows):
        show(line)


def show_violations(violations: Sequence[Violation]) -> None:
    """Print the first violations, a line each, in order of time."""
    if not violations:
        return
    show("")
    for violation in violations[:_MOST]:
        show(f"{violation.at / NANOSECONDS:9.3f} s  {violation.property}: {printable(violation.text)}")
    if len(violations) > _MOST:
        show(f"... and {len(violations) - _MOST} more")
