"""The results of an experiment as tables on a terminal, and for other programs."""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from typing import TYPE_CHECKING, Any, Final

from rich.console import Console
from rich.table import Table
from rich.text import Text

from hmrsim.cli.exits import ExitCode, WrongUse
from hmrsim.cli.output import show as say
from hmrsim.cli.output import show_json
from hmrsim.errors import ResultsError, printable
from hmrsim.experiments.results.repeats import note_of
from hmrsim.experiments.results.store import FILE, TRACES, Results
from hmrsim.experiments.results.table import Group, groups_by, groups_of, write_csv, write_json, write_table
from hmrsim.program.outputs import check_outputs
from hmrsim.report.html import UNKNOWN

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim.experiments.statistics.intervals import Interval

_MAX_FAILED: Final = 10
_WIDTH: Final = 200


def status(args: argparse.Namespace) -> int:
    """Show how far an experiment is; return the exit code."""
    with Results(args.results) as results:
        about, endings = results.about, results.count("ending")
    done = sum(endings.values())
    cells = about["scenarios"] * len(about["treatments"])
    least, most = (cells * about["replications"][key] for key in ("min", "max"))
    if about["replications"]["until"] is None:
        least = most
    if args.json:
        show_json({"name": about["name"], "done": done, "min": least, "max": most, "endings": endings})
        return ExitCode.DONE
    wanted = f"{most:,}" if least == most else f"{least:,} to {most:,}"
    say(f"{about['name']}: {done:,} of {wanted} runs have a result")
    for ending, count in endings.items():
        say(f"  {ending}: {count:,}")
    return ExitCode.DONE


def show(args: argparse.Namespace) -> int:
    """Show the results of an experiment, or of one run; return the exit code."""
    with Results(args.results) as results:
        if args.run is not None:
            return _show_run(args, results)
        about = results.about
        if args.file:
            say(about["text"].rstrip("\n"))
            return ExitCode.DONE
        groups = _groups(results, args)
        columns = ["number", "treatment", *about["factors"], "ending", "cause"]
        failed = [*results.rows(columns, {"success": 0})]
    if args.json:
        show_json({"name": about["name"], "treatments": [_values(group) for group in groups]})
        return ExitCode.DONE
    console = Console(width=None if Console().is_terminal else _WIDTH)
    console.print(_table(groups, [*about["measures"]], args.by))
    for note in _notes(groups):
        say(printable(note))
    for row in failed[:_MAX_FAILED]:
        cause = f": {row['cause']}" if row["cause"] else ""
        levels = "".join(f", {factor} {row[factor]}" for factor in about["factors"])
        say(printable(f"run {row['number']} ({row['treatment']}{levels}) {row['ending']}{cause}"))
        say(f"  hmrsim experiment again {args.results} {row['number']} --trace run_{row['number']}.jsonl")
    if len(failed) > _MAX_FAILED:
        say(f"… and {len(failed) - _MAX_FAILED} more without success; see `hmrsim experiment export {args.results}`")
    return ExitCode.DONE


def export(args: argparse.Namespace) -> int:
    """Write the table of runs; return the exit code."""
    with Results(args.results) as results:
        if args.output is None:
            write_json(results, sys.stdout) if args.json else write_csv(results, sys.stdout)
        else:
            check_outputs([("--output", args.output)], [args.results / FILE])
            write_table(results, args.output)
    return ExitCode.DONE


def _groups(results: Results, args: argparse.Namespace) -> list[Group]:
    if not args.by:
        return [*groups_of(results).values()]
    try:
        return groups_by(results, args.by)
    except ValueError as error:
        raise WrongUse(f"--by: {error}") from None


def _show_run(args: argparse.Namespace, results: Results) -> int:
    row = next(results.rows(where={"number": args.run}), None)
    if row is None:
        raise ResultsError(f"{args.results}: there is no run {args.run}; `hmrsim experiment status` tells how many are")
    trace = args.results / TRACES / f"{args.run}.jsonl"
    if args.json:
        show_json({**row, "trace": str(trace) if trace.is_file() else None})
        return ExitCode.DONE
    for name, value in row.items():
        say(printable(f"{name}: {value}") if name != "output" else f"output:\n{printable_lines(str(value))}")
    if trace.is_file():
        say(f"trace: {trace}")
    say(f"again: hmrsim experiment again {args.results} {args.run} --trace run_{args.run}.jsonl")
    return ExitCode.DONE


def printable_lines(text: str) -> str:
    """Return the lines of a text, each indented and without control characters."""
    return "\n".join(f"  {printable(line)}" for line in text.splitlines())


def _table(groups: list[Group], measures: list[str], factors: list[str]) -> Table:
    table = Table(box=None, pad_edge=False)
    for factor in factors:
        table.add_column(Text(factor))
    for heading in ("treatment", "runs", "success", *measures):
        table.add_column(heading, justify="left" if heading == "treatment" else "right")
    for group in groups:
        rate = group.rate()
        means = [_interval(group.mean(measure)) for measure in measures]
        levels = [Text(printable(str(level))) for level in group.levels.values()]
        table.add_row(*levels, Text(group.name), f"{group.runs:,}", _interval(rate, share=True), *means)
    return table


def _notes(groups: list[Group]) -> Iterator[str]:
    """Yield in words what the means and intervals of each treatment are of, where that is not what one might think."""
    for name in dict.fromkeys(group.name for group in groups):
        own = [group for group in groups if group.name == name]
        if note := note_of(sum(group.runs for group in own), sum(group.count for group in own)):
            yield f"{name}: {note}"
        failed = sum((group.failed for group in own), Counter[str]())
        if failed:
            said = ", ".join(f"{count:,} of {measure}" for measure, count in sorted(failed.items()))
            yield f"{name}: means include values of runs without success: {said}"


def _interval(interval: Interval, *, share: bool = False) -> str:
    """Return an estimate with its 95 % interval."""
    if interval.estimate is None:
        return UNKNOWN
    form = ".1%" if share else ".4g"
    if interval.low is None or interval.high is None:
        return format(interval.estimate, form)
    return f"{interval.estimate:{form}} [{interval.low:{form}}, {interval.high:{form}}]"


def _values(group: Group) -> dict[str, Any]:
    means = {measure: {**_plain(group.mean(measure)), "failed": group.failed[measure]} for measure in group.values}
    return {
        "name": group.name,
        **({"levels": dict(group.levels)} if group.levels else {}),
        "runs": group.runs,
        "count": group.count,
        "success": _plain(group.rate()),
        "endings": dict(group.endings),
        "measures": means,
    }


def _plain(interval: Interval) -> dict[str, Any]:
    return {"estimate": interval.estimate, "low": interval.low, "high": interval.high, "n": interval.n}
