"""Repeating one run of an experiment."""

from __future__ import annotations

import argparse
from contextlib import ExitStack
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.first_difference import difference_from
from hmrsim.cli.output import show, show_json, warn
from hmrsim.cli.run_recording import recorded
from hmrsim.errors import ResultsError
from hmrsim.experiments.file.reading import read_plan
from hmrsim.experiments.results.store import FILE, TRACES, Results
from hmrsim.experiments.running.replications import execute_run
from hmrsim.program.outputs import check_outputs, unwritable
from hmrsim.report import of_trace
from hmrsim.report.compile import report_of
from hmrsim.report.page import page_of
from hmrsim.settings.run import RunSettings
from hmrsim_zenoh.hosting.served_simulation import unwatched

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.experiments.file.plan import Plan
    from hmrsim.experiments.results.store import Row


def again(args: argparse.Namespace) -> int:
    """Repeat a run; return the exit code."""
    with Results(args.results) as results:
        before = next(results.rows(where={"number": args.run}), None)
        plan = _plan(results, args.results)
    outputs = [("--trace", args.trace), ("--report", args.report), ("--record", args.record)]
    check_outputs(outputs, [plan.path, args.results / FILE])
    run = plan.run_of(args.run)
    if run is None:
        raise ResultsError(f"{args.results}: there is no run {args.run}")
    with ExitStack() as stack:
        settings = RunSettings(clock="lockstep")
        watchers = stack.enter_context(recorded(args.record, settings)) if args.record else unwatched
        row = execute_run(_traced(plan), run, watchers)
    if args.trace:
        _write(args.trace, row.trace)
    if args.report and row.trace:
        (source,) = of_trace(lambda: row.trace.splitlines(keepends=True), section=1)
        _write(args.report, page_of(report_of(source), source.definition))
    now = _values(plan, row)
    if args.json:
        show_json({"run": args.run, **now, "same": before is None or not _different(before, now)})
    else:
        for name, value in now.items():
            show(f"{name}: {value}")
    if before is None:
        warn(f"run {args.run} has no result yet to compare with")
        return ExitCode.DONE
    different = _different(before, now)
    for name in different:
        warn(f"{name} was {before[name]!r} and is {now[name]!r} now")
    if different:
        warn(difference_from(_kept(args.results, args.run), row.trace, _trace_of, args.results, args.run))
    return ExitCode.FAILED if different else ExitCode.DONE


def _write(path: Path, text: str) -> None:
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise unwritable(str(path), error) from None


def _kept(folder: Path, number: int) -> str:
    """Return the trace of a run that was kept; empty if none was."""
    try:
        return (folder / TRACES / f"{number}.jsonl").read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ""


def _trace_of(folder: Path, number: int) -> str:
    """Return the trace of a run, which is made once more."""
    with Results(folder) as results:
        plan = _plan(results, folder)
    run = plan.run_of(number)
    return "" if run is None else execute_run(_traced(plan), run).trace


def _traced(plan: Plan) -> Plan:
    """Return a plan that keeps all traces."""
    keep = plan.file.keep.model_copy(update={"traces": "all"})
    file = plan.file.model_copy(update={"keep": keep})
    return replace(plan, file=file)


def _plan(results: Results, folder: Path) -> Plan:
    about = results.about
    plan = read_plan(about["path"], about["variant"])
    if plan.hash != about["hash"]:
        was = f"`hmrsim experiment show {folder} --file` prints it"
        raise ResultsError(
            f"{about['path']}: has changed since these results; repeat them, or take the file as it was ({was})"
        )
    return plan


def _values(plan: Plan, row: Row) -> dict[str, Any]:
    levels = plan.scenarios[row.run.scenario]
    judged = {"ending": row.ending, "cause": row.cause, "at": row.at}
    return {"treatment": row.run.treatment, "seed": row.run.seed, **levels, **judged, **row.measures}


def _different(before: dict[str, Any], now: dict[str, Any]) -> list[str]:
    return [name for name, value in now.items() if name != "cause" and before[name] != value]
