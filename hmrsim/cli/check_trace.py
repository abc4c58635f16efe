"""``hmrsim check --trace``: apply properties to the run of a trace or a recording."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import columns, show_result, warn
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

_MAX_VIOLATIONS: Final = 50
"""Violations to print."""
_WORDS: Final = {"never_exercised": "never exercised"}


def check_trace(args: argparse.Namespace) -> int:
    """Apply the properties to the run; return the exit code: 1 if one is violated.

    Raises:
        TraceError: The file is neither a trace nor a recording.
        PropertyError: The properties are not valid, or refer to something that the world lacks.
    """
    properties = Properties() if args.properties is None else read_properties(args.properties)
    collect_rarely()
    with logging_to_stderr(args):
        checked = _checked(args.trace, properties)
    for note in checked.notes:
        warn(f"{args.trace}: {printable(note)}")
    monitor = checked.monitor
    lines = (*_verdict_lines(monitor.verdicts()), *_violation_lines(monitor.violations))
    show_result(_facts(checked), lines, as_json=args.json)
    return ExitCode.FAILED if monitor.violations else ExitCode.DONE


def _checked(path: Path, properties: Properties) -> Checked:
    # Misspelled names are reported before a long run is replayed.
    found = partial(show_findings, properties)
    with errors_of(path, no_text="neither a trace (text) nor a recording (MCAP)"):
        if is_recording(path):
            return check_recording(open_recording(path), properties, found)
        return check_lines(lambda: lines_of(path), properties, found)


def _facts(checked: Checked) -> dict[str, Any]:
    monitor = checked.monitor
    return {
        "violated": bool(monitor.violations),
        "verdicts": [verdict.as_dict() for verdict in monitor.verdicts()],
        "violations": [violation.as_dict() for violation in monitor.violations],
        "notes": list(checked.notes),
    }


def _verdict_lines(verdicts: Sequence[Verdict]) -> Iterator[str]:
    """Return a line for each property."""
    rows = [("property", "verdict", "robustness", "")]
    for verdict in verdicts:
        robustness = f"{verdict.robustness:+.2f}" if verdict.state in {"holds", "violated"} else ""
        rows.append((verdict.property, _WORDS.get(verdict.state, verdict.state), robustness, verdict.text))
    return columns(rows)


def _violation_lines(violations: Sequence[Violation]) -> Iterator[str]:
    """Yield a line for each of the first violations, in order of time."""
    if not violations:
        return
    yield ""
    for violation in violations[:_MAX_VIOLATIONS]:
        yield f"{violation.at / NANOSECONDS:9.3f} s  {violation.property}: {printable(violation.text)}"
    if len(violations) > _MAX_VIOLATIONS:
        yield f"... and {len(violations) - _MAX_VIOLATIONS} more"
