"""``hmrsim compare``: compare two treatments run by run, or two traces line by line."""

from __future__ import annotations

import argparse
import math
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, add_json, number_in
from hmrsim.cli.output import show, show_json, show_result, show_table, warn
from hmrsim.errors import printable

if TYPE_CHECKING:
    from hmrsim.experiments.contrast import Contrast

_MAX_ENDINGS: Final = 10
_MAX_LINE: Final = 500


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``hmrsim compare``."""
    parser.description = (
        "Compare two treatments of experiments, run by run under the same seeds: is B better than A, worse, or\n"
        "equivalent? You can check the verdict as often as you like while the experiments run. For two traces, show\n"
        "the first difference."
    )
    parser.epilog = """\
exit codes: 0 no verdict is worse, the traces are identical; 1 a verdict is worse, the traces differ; 2 they can't be
compared

examples:
  hmrsim compare results:nearest results:planned
  hmrsim compare before after --measure time --margin time=2
  hmrsim compare run_1.jsonl run_2.jsonl"""
    for name in ("a", "b"):
        parser.add_argument(
            name, metavar=name.upper(), help="DIR or DIR:TREATMENT of an experiment's results, or a trace"
        )
    parser.add_argument(
        "--measure", action="append", default=[], metavar="NAME", help="compare this measure only; repeatable (all)"
    )
    parser.add_argument(
        "--margin",
        action="append",
        default=[],
        metavar="MEASURE=X",
        type=_margin,
        help="treat differences of the means up to X as equal; repeatable (as the experiment says)",
    )
    parser.add_argument(
        "--alpha",
        type=number_in(0.0, math.nextafter(1.0, 0.0), "a probability between 0 and 1"),
        default=0.05,
        metavar="P",
        help="probability that any verdict is false (0.05)",
    )
    add_json(parser)
    parser.set_defaults(function=_compare)


def _margin(text: str) -> tuple[str, float]:
    name, equals, number = text.partition("=")
    try:
        value = float(number)
    except ValueError:
        value = -1.0
    if not equals or not name or not 0.0 <= value < 1e300:  # noqa: PLR2004 - finite
        raise argparse.ArgumentTypeError(f"{text!r} is not MEASURE=NUMBER with a number that is not negative")
    return name, value


def _compare(args: argparse.Namespace) -> int:
    if Path(args.a).is_file() and Path(args.b).is_file():
        return _compare_traces(args)
    from hmrsim.experiments.contrast import contrast, sides_of
    from hmrsim.experiments.statistics.verdicts import WORSE

    result = contrast(*sides_of(args.a, args.b), measures=args.measure, margins=dict(args.margin), alpha=args.alpha)
    if args.json:
        show_json(_values(result))
    else:
        _show(result, args.alpha)
    return ExitCode.FAILED if any(each.verdict == WORSE for each in result.comparisons.values()) else ExitCode.DONE


def _values(result: Contrast) -> dict[str, Any]:
    return {
        "a": str(result.a),
        "b": str(result.b),
        "pairs": result.pairs,
        "alone": list(result.alone),
        "measures": {name: asdict(each) for name, each in result.comparisons.items()},
        "endings": [dict(zip(("a", "b", "ending_a", "ending_b"), each, strict=True)) for each in result.endings],
        "notes": list(result.notes),
    }


def _show(result: Contrast, alpha: float) -> None:
    from hmrsim.report.html import UNKNOWN

    show(f"{result.b} compared with {result.a}: {result.pairs:,} pairs")
    for note in result.notes:
        warn(f"warning: {note}")
    rows = []
    for name, each in result.comparisons.items():
        mean = each.difference
        bounds = f" [{mean.low:+.4g}, {mean.high:+.4g}]" if mean.low is not None and mean.high is not None else ""
        difference = UNKNOWN if mean.estimate is None else f"{mean.estimate:+.4g}{bounds}"
        after = UNKNOWN if each.decided_after is None else f"{each.decided_after:,}"
        rows.append((name, each.verdict, after, difference, f"{each.differing:,}"))
    headings = ("measure", "verdict", "after pairs", f"difference, {1 - alpha:.0%} together", "pairs that differ")
    show_table(headings, rows, left=("measure", "verdict"))
    for number_a, number_b, ending_a, ending_b in result.endings[:_MAX_ENDINGS]:
        show(printable(f"run {number_a} {ending_a}, run {number_b} {ending_b}"))
        show(printable(f"  hmrsim experiment again {result.b.folder} {number_b} --trace run_{number_b}.jsonl"))
    if len(result.endings) > _MAX_ENDINGS:
        show(f"... and {len(result.endings) - _MAX_ENDINGS} more pairs ended otherwise; see --json")


def _compare_traces(args: argparse.Namespace) -> int:
    from hmrsim.trace.difference import compared

    same, difference = compared(_lines(Path(args.a)), _lines(Path(args.b)))
    if difference is None:
        facts: dict[str, Any] = {"identical": True, "line": None, "a": None, "b": None}
        show_result(facts, f"identical: {same} lines", as_json=args.json)
        return ExitCode.DONE
    facts = {"identical": False, "line": difference.line, "a": difference.was, "b": difference.now}
    lines = (f"line {difference.line} differs", f"- {_cut(difference.was)}", f"+ {_cut(difference.now)}")
    show_result(facts, map(printable, lines), as_json=args.json)
    return ExitCode.FAILED


def _lines(path: Path) -> Iterator[str]:
    from hmrsim.cli.replay import errors_of, lines_of

    with errors_of(path, no_text="can't be read: is not text"):
        yield from (line.rstrip("\n") for line in lines_of(path))


def _cut(line: str | None) -> str:
    return "(it ends before)" if line is None else line if len(line) <= _MAX_LINE else f"{line[:_MAX_LINE]}..."
