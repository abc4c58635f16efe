"""``hmrsim experiment check``, ``run`` and ``again``: checking an experiment, making its runs, and repeating one."""

from __future__ import annotations

import argparse
import time
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.cli.options import ExitCode, WrongUse
from hmrsim.cli.output import ProgressLine, counted, show, show_json, show_result, warn
from hmrsim.cli.replay import difference_from
from hmrsim.errors import ResultsError
from hmrsim.experiments.campaign import Campaign, Progress
from hmrsim.experiments.checking import check_file
from hmrsim.experiments.contrast import withdrawal
from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.replications import execute_run
from hmrsim.experiments.run_page import run_logged, run_page
from hmrsim.experiments.store import FILE, TRACES, Results
from hmrsim.program.files import check_outputs, check_writable, write_text
from hmrsim.settings.run import RunSettings
from hmrsim.timing.pacing import unwatched
from hmrsim.trials.batches import factory_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.experiments.plan import Plan, Run
    from hmrsim.experiments.statistics.verdicts import Comparison
    from hmrsim.experiments.store import Row
    from hmrsim.run_page import RunLog

_PERIOD: Final = 60.0
"""Wall seconds between two lines of progress without a terminal."""


def check(args: argparse.Namespace) -> int:
    """Check an experiment; return the exit code."""
    plan = _checked(args)
    show_result(_facts(plan), _summary(plan), as_json=args.json)
    return ExitCode.DONE


def run(args: argparse.Namespace) -> int:
    """Make the runs of an experiment; return the exit code."""
    make, workers = factory_of(args.executor, args.jobs)
    plan = _checked(args)
    folder = args.output or Path(plan.file.name)
    with Results.create(folder, plan) as results:
        display = _JsonDisplay() if args.json else _TextDisplay(folder)
        campaign = Campaign(plan, results, make, workers, display.update)
        if campaign.progress.done and not args.json:
            warn(f"{folder}: continues; {campaign.progress.done} of {campaign.progress.expected} runs have results")
        try:
            progress = campaign.run()
        except KeyboardInterrupt:
            display.end(campaign.progress, {})
            done = f"{campaign.progress.done:,} of {campaign.progress.expected:,} runs have results"
            warn(f"interrupted; {done}, and the same command continues")
            return ExitCode.INTERRUPTED
        comparisons = campaign.comparisons()
        display.end(progress, comparisons)
        if not args.json:
            _sum_up(folder, plan, results, progress)
            for name, comparison in comparisons.items():
                show(_decision(plan, name, comparison))
    return ExitCode.DONE


def _checked(args: argparse.Namespace) -> Plan:
    plan, warnings = check_file(args.file, args.variant)
    for problem in warnings:
        warn(f"warning: {problem}")
    return plan


def _facts(plan: Plan) -> dict[str, object]:
    replications = plan.file.replications
    return {
        "name": plan.file.name,
        "hash": plan.hash,
        "scenarios": len(plan.scenarios),
        "treatments": [*plan.treatments],
        "replications": {"min": replications.min, "max": replications.max},
        "runs": {"min": _count(plan, replications.min), "max": _count(plan, replications.max)},
        "measures": [*plan.file.measures],
    }


def _count(plan: Plan, replications: int) -> int:
    return len(plan.scenarios) * len(plan.treatments) * replications


def _summary(plan: Plan) -> str:
    replications = plan.file.replications
    most = _count(plan, replications.max)
    least = _count(plan, replications.min) if replications.until else most
    runs = f"{most:,} runs" if least == most else f"{least:,} to {most:,} runs"
    return (
        f"{plan.file.name}: {runs}: {counted(len(plan.scenarios), 'scenarios')}, "
        f"{counted(len(plan.treatments), 'treatments')} ({', '.join(plan.treatments)})"
    )


def _sum_up(folder: Path, plan: Plan, results: Results, progress: Progress) -> None:
    seconds = time.monotonic() - progress.began
    pace = f", {progress.made / seconds:,.1f} runs/s" if progress.made else ""
    show(f"{plan.file.name}: {progress.done:,} runs, {progress.made:,} of them now in {seconds:.1f} s{pace}")
    for ending, count in results.count("ending").items():
        show(f"  {ending}: {count:,}")
    if plan.file.keep.coverage:
        show(f"coverage: `bt-controller coverage {folder}/coverage_TREATMENT.json` for each treatment with a tree")
    show(f"results: {folder / FILE}; `hmrsim experiment show {folder}`, `hmrsim experiment report {folder}`")


def _decision(plan: Plan, name: str, comparison: Comparison) -> str:
    """Return the verdict that decided the number of replications."""
    until, pairs = plan.file.replications.until, comparison.difference.n
    first, measure = next(iter(plan.treatments)), until.measure if until else ""
    after = f"{pairs:,}" if comparison.decided_after is None else f"{comparison.decided_after:,} of {pairs:,}"
    text = f"{measure} of {name} compared with {first}: {comparison.verdict} after {after} pairs"
    return f"{text}; {withdrawal(comparison)}" if comparison.withdrawn else text


class _TextDisplay:
    """Shows progress, on one line of a terminal or once a minute, and the first run that crashed or hung."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._line = ProgressLine(_PERIOD)
        self._mishap_shown = False

    def update(self, progress: Progress) -> None:
        """Show the progress, and the first run that crashed or hung."""
        if progress.mishap is not None and not self._mishap_shown:
            self._mishap_shown = True
            self._show_mishap(progress.mishap)
        self._line.report(lambda: _text(progress))

    def end(self, _progress: Progress, _comparisons: Mapping[str, Comparison]) -> None:
        """Clear the line."""
        self._line.show()

    def _show_mishap(self, row: Row) -> None:
        self._line.show()
        cause = f": {row.cause}" if row.cause else ""
        warn(f"warning: run {row.run.number} ({row.run.treatment}) {row.ending}{cause}")
        warn(f"  hmrsim experiment show {self._folder} {row.run.number}")


class _JsonDisplay:
    """Prints the progress of an experiment as lines of JSON."""

    def update(self, progress: Progress) -> None:
        """Print a line."""
        show_json(_counts(progress))

    def end(self, progress: Progress, comparisons: Mapping[str, Comparison]) -> None:
        """Print the last line."""
        verdicts = {
            name: {"verdict": each.verdict, "decided_after": each.decided_after, "withdrawn": [*each.withdrawn]}
            for name, each in comparisons.items()
        }
        show_json({**_counts(progress), "over": True, **({"verdicts": verdicts} if verdicts else {})})


def _counts(progress: Progress) -> dict[str, int]:
    return {"done": progress.done, "expected": progress.expected, "failed": progress.failed.total()}


def _text(progress: Progress) -> str:
    left = progress.seconds_left
    time_left = "" if left is None else f", {_duration(left)} left"
    share = f"{progress.done / progress.expected:.0%}" if progress.expected else ""
    failed = "".join(f", {count:,} {ending}" for ending, count in progress.failed.most_common())
    return f"{progress.done:,} of {progress.expected:,} runs ({share}){failed}{time_left}"


def _duration(seconds: float) -> str:
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min" if hours else f"{minutes} min {rest:02d} s" if minutes else f"{rest} s"


def again(args: argparse.Namespace) -> int:
    """Repeat a run, and check that the result is the same; return the exit code."""
    from hmrsim.cli.record import recorded

    with Results(args.results) as results:
        before = next(results.rows(where={"number": args.run}), None)
        plan = _plan(results, args.results)
        run = plan.run_of(args.run)
        if run is None:
            raise ResultsError(f"{args.results}: there is no run {args.run}")
        beside = _beside(args, plan, run, results)
    outputs = [("--trace", args.trace), ("--report", args.report), ("--record", args.record), ("--page", args.page)]
    check_outputs(outputs, [plan.path, args.results / FILE])
    if args.page:
        check_writable("--page", args.page)
    with ExitStack() as stack:
        settings = RunSettings(clock="lockstep")
        watchers = stack.enter_context(recorded(args.record, settings)) if args.record else unwatched
        if args.page is None:
            row, log = execute_run(_traced(plan), run, watchers), None
        else:
            row, log = run_logged(_traced(plan), run, watchers)
    if args.trace:
        write_text("--trace", args.trace, row.trace)
    if args.report and row.trace:
        from hmrsim.report import of_trace
        from hmrsim.report.compile import report_of
        from hmrsim.report.page import page_of

        (source,) = of_trace(lambda: row.trace.splitlines(keepends=True), section=1)
        write_text("--report", args.report, page_of(report_of(source), source.definition))
    if log is not None:
        _write_page(args.page, plan, row, log, beside)
    now = _outcome(plan, row)
    different = [name for name, value in now.items() if before and name != "cause" and before[name] != value]
    facts = {"run": args.run, **now, "same": not different}
    show_result(facts, (f"{name}: {value}" for name, value in now.items()), as_json=args.json)
    if before is None:
        warn(f"run {args.run} has no result yet to compare with")
        return ExitCode.DONE
    for name in different:
        warn(f"{name} was {before[name]!r} and is {now[name]!r} now")
    if different:
        warn(difference_from(_kept(args.results, args.run), row.trace, _trace_of, args.results, args.run))
    return ExitCode.FAILED if different else ExitCode.DONE


def _beside(args: argparse.Namespace, plan: Plan, run: Run, results: Results) -> Run | None:
    """Return the run of another treatment to show beside a run: the chosen one, else the first success, else any."""
    if args.beside is None:
        others = [plan.run(run.scenario, name, run.replication) for name in plan.treatments if name != run.treatment]
        known = {row["number"] for row in results.rows(["number"], {"success": 1})}
        return next((each for each in others if each.number in known), next(iter(others), None))
    if args.page is None:
        raise WrongUse(f"--beside {args.beside}: it is for --page alone; name a page, or leave it out")
    if args.beside == run.treatment or args.beside not in plan.treatments:
        names = ", ".join(name for name in plan.treatments if name != run.treatment)
        raise WrongUse(f"--beside {args.beside}: no other treatment of that name; there are: {names or 'none'}")
    return plan.run(run.scenario, args.beside, run.replication)


def _write_page(path: Path, plan: Plan, row: Row, log: RunLog, beside: Run | None) -> None:
    if not log.watched:
        warn(f"--page {path}: not written, since the run has not begun")
        return
    write_text("--page", path, run_page(plan, row, log, beside))
    warn(f"page: {path}")


def _kept(folder: Path, number: int) -> str:
    """Return the kept trace of a run; empty if none was kept."""
    try:
        return (folder / TRACES / f"{number}.jsonl").read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return ""


def _trace_of(folder: Path, number: int) -> str:
    with Results(folder) as results:
        plan = _plan(results, folder)
    run = plan.run_of(number)
    return "" if run is None else execute_run(_traced(plan), run).trace


def _traced(plan: Plan) -> Plan:
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


def _outcome(plan: Plan, row: Row) -> dict[str, Any]:
    levels = plan.scenarios[row.run.scenario]
    judged = {"ending": row.ending, "cause": row.cause, "at": row.at}
    return {"treatment": row.run.treatment, "seed": row.run.seed, **levels, **judged, **row.measures}
