"""``hmrsim experiment status``, ``show``, ``report`` and ``export``: the results of an experiment."""

from __future__ import annotations

import argparse
import shlex
import sys
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, WrongUse
from hmrsim.cli.output import show, show_json, show_result, show_table
from hmrsim.errors import ResultsError, printable
from hmrsim.experiments.repeats import note_of
from hmrsim.experiments.store import FILE, TRACES, Results
from hmrsim.experiments.table import Group, groups_by, write_csv, write_json, write_table
from hmrsim.program.files import STDOUT, check_outputs, write_text
from hmrsim.report.html import UNKNOWN

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from hmrsim.experiments.statistics.intervals import Interval

_MAX_FAILED: Final = 10
_PAGE: Final = "report.html"
"""The name of the page in the folder of results, if no other is given."""


def status(args: argparse.Namespace) -> int:
    """Show how far an experiment is; return the exit code."""
    with Results(args.results) as results:
        about, endings = results.about, results.count("ending")
    done = sum(endings.values())
    cells = about["scenarios"] * len(about["treatments"])
    least, most = (cells * about["replications"][key] for key in ("min", "max"))
    if about["replications"]["until"] is None:
        least = most
    runs = f"{most:,}" if least == most else f"{least:,} to {most:,}"
    lines = [f"{about['name']}: {done:,} of {runs} runs have a result"]
    lines += [f"  {ending}: {count:,}" for ending, count in endings.items()]
    facts = {"name": about["name"], "done": done, "min": least, "max": most, "endings": endings}
    show_result(facts, lines, as_json=args.json)
    return ExitCode.DONE


def show_results(args: argparse.Namespace) -> int:
    """Show the results of an experiment, or of one run; return the exit code."""
    with Results(args.results) as results:
        if args.run is not None:
            return _show_run(args, results)
        about = results.about
        if args.file:
            show(about["text"].rstrip("\n"))
            return ExitCode.DONE
        groups = _groups(results, args)
        columns = ["number", "treatment", *about["factors"], "ending", "cause"]
        failed = [*results.rows(columns, {"success": 0})]
    if args.json:
        show_json({"name": about["name"], "treatments": [_values(group) for group in groups]})
        return ExitCode.DONE
    headings = (*args.by, "treatment", "runs", "success", *about["measures"])
    show_table(headings, (_row(group, about["measures"]) for group in groups), left=(*args.by, "treatment"))
    for note in _notes(groups):
        show(printable(note))
    for row in failed[:_MAX_FAILED]:
        cause = f": {row['cause']}" if row["cause"] else ""
        levels = "".join(f", {factor} {row[factor]}" for factor in about["factors"])
        show(printable(f"run {row['number']} ({row['treatment']}{levels}) {row['ending']}{cause}"))
        show(f"  hmrsim experiment again {args.results} {row['number']} --trace run_{row['number']}.jsonl")
    if len(failed) > _MAX_FAILED:
        show(f"… and {len(failed) - _MAX_FAILED} more without success; see `hmrsim experiment export {args.results}`")
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
        show(printable(f"{name}: {value}") if name != "output" else f"output:\n{_printable_lines(str(value))}")
    if trace.is_file():
        show(f"trace: {trace}")
    show(f"again: hmrsim experiment again {args.results} {args.run} --trace run_{args.run}.jsonl")
    return ExitCode.DONE


def _printable_lines(text: str) -> str:
    """Return the lines of a text, each indented and without control characters."""
    return "\n".join(f"  {printable(line)}" for line in text.splitlines())


def _row(group: Group, measures: Iterable[str]) -> tuple[str, ...]:
    levels, means = map(str, group.levels.values()), (_interval(group.mean(measure)) for measure in measures)
    return *levels, group.name, f"{group.runs:,}", _interval(group.rate(), share=True), *means


def _notes(groups: list[Group]) -> Iterator[str]:
    """Yield notes about means and intervals that may not be what the user expects."""
    for name in dict.fromkeys(group.name for group in groups):
        own = [group for group in groups if group.name == name]
        if note := note_of(sum(group.runs for group in own), sum(group.count for group in own)):
            yield f"{name}: {note}"
        failed = sum((group.failed for group in own), Counter[str]())
        if failed:
            counts = ", ".join(f"{count:,} of {measure}" for measure, count in sorted(failed.items()))
            yield f"{name}: means include values of runs without success: {counts}"


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


def report(args: argparse.Namespace) -> int:
    """Write the page of an experiment's results, or print what is on it; return the exit code."""
    from hmrsim.experiments.report import page_of, summary_of

    if args.json and args.output == STDOUT:
        raise WrongUse("hmrsim experiment report: -o - and --json both write to the standard output; give -o a file")
    output = args.output or (None if args.json else str(args.results / _PAGE))
    check_outputs([("-o", output)], [args.results / f"{FILE}{end}" for end in ("", "-wal", "-shm")])
    with Results(args.results) as results:
        summary = summary_of(results)
    if output is not None:
        page = page_of(summary, shlex.quote(str(args.results)))
        if output == STDOUT:
            show(page)
            return ExitCode.DONE
        write_text("-o", Path(output), page)
        if not args.json:
            show(f"page: {output}")
    if args.json:
        show_json(summary.model_dump(mode="json"))
    return ExitCode.DONE
