"""Comparing treatments or traces from the command line."""

from __future__ import annotations

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json, warn
from hmrsim.errors import TraceError, printable, reason_of
from hmrsim.experiments.contrast import Contrast, contrast, sides_of
from hmrsim.experiments.statistics.verdicts import WORSE
from hmrsim.report.html import UNKNOWN
from hmrsim.trace.difference import compared

if TYPE_CHECKING:
    from collections.abc import Iterator

_MAX_ENDINGS: Final = 10
_WIDTH: Final = 200
_MAX_LINE: Final = 500


def compare(args: argparse.Namespace) -> int:
    """Compare two treatments, or two traces; return the exit code."""
    if Path(args.a).is_file() and Path(args.b).is_file():
        return _compare_traces(args)
    found = contrast(*sides_of(args.a, args.b), measures=args.measure, margins=dict(args.margin), alpha=args.alpha)
    if args.json:
        show_json(_values(found))
    else:
        _show(found, args.alpha)
    return ExitCode.FAILED if any(each.verdict == WORSE for each in found.comparisons.values()) else ExitCode.DONE


def _values(found: Contrast) -> dict[str, Any]:
    return {
        "a": str(found.a),
        "b": str(found.b),
        "pairs": found.pairs,
        "alone": list(found.alone),
        "measures": {name: asdict(each) for name, each in found.comparisons.items()},
        "endings": [dict(zip(("a", "b", "ending_a", "ending_b"), each, strict=True)) for each in found.endings],
        "notes": list(found.notes),
    }


def _show(found: Contrast, alpha: float) -> None:
    show(f"{found.b} compared with {found.a}: {found.pairs:,} pairs")
    for note in found.notes:
        warn(f"warning: {note}")
    table = Table(box=None, pad_edge=False)
    for heading in ("measure", "verdict", "after pairs", f"difference, {1 - alpha:.0%} together", "pairs that differ"):
        table.add_column(heading, justify="left" if heading in {"measure", "verdict"} else "right")
    for name, each in found.comparisons.items():
        mean = each.difference
        bounds = f" [{mean.low:+.4g}, {mean.high:+.4g}]" if mean.low is not None and mean.high is not None else ""
        told = UNKNOWN if mean.estimate is None else f"{mean.estimate:+.4g}{bounds}"
        after = UNKNOWN if each.decided_after is None else f"{each.decided_after:,}"
        table.add_row(Text(name), each.verdict, after, told, f"{each.differing:,}")
    Console(width=None if Console().is_terminal else _WIDTH).print(table)
    for number_a, number_b, ending_a, ending_b in found.endings[:_MAX_ENDINGS]:
        show(printable(f"run {number_a} {ending_a}, run {number_b} {ending_b}"))
        show(printable(f"  hmrsim experiment again {found.b.folder} {number_b} --trace run_{number_b}.jsonl"))
    if len(found.endings) > _MAX_ENDINGS:
        show(f"... and {len(found.endings) - _MAX_ENDINGS} more pairs ended otherwise; see --json")


def _compare_traces(args: argparse.Namespace) -> int:
    same, found = compared(_lines(args.a), _lines(args.b))
    if args.json:
        line, one, two = found or (None, None, None)
        show_json({"identical": found is None, "line": line, "a": one, "b": two})
    elif found is None:
        show(f"identical: {same} lines")
    else:
        show(f"line {found.line} differs")
        show(printable(f"- {_cut(found.was)}"))
        show(printable(f"+ {_cut(found.now)}"))
    return ExitCode.DONE if found is None else ExitCode.FAILED


def _lines(path: str) -> Iterator[str]:
    try:
        with Path(path).open(encoding="utf-8") as file:
            yield from (line.rstrip("\n") for line in file)
    except (OSError, UnicodeDecodeError) as error:
        why = reason_of(error) if isinstance(error, OSError) else "is not text"
        raise TraceError(f"{path}: can't be read: {why}") from None


def _cut(line: str | None) -> str:
    return "(it ends before)" if line is None else line if len(line) <= _MAX_LINE else f"{line[:_MAX_LINE]}..."
