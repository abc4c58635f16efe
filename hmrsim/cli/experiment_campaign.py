"""Checking and running experiments from the command line."""

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import TYPE_CHECKING, Final

from hmrsim.cli.exits import ExitCode
from hmrsim.cli.output import show, show_json, warn
from hmrsim.cli.terminal_line import TerminalLine
from hmrsim.experiments.contrast import withdrawal
from hmrsim.experiments.results.store import FILE, Results
from hmrsim.experiments.running.campaign import Campaign, Progress
from hmrsim.experiments.running.checking import check_file
from hmrsim.trials.batches import factory_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from hmrsim.experiments.file.plan import Plan
    from hmrsim.experiments.results.store import Row
    from hmrsim.experiments.statistics.verdicts import Comparison

_MINUTE: Final = 60.0
_LOOK: Final = 0.2
"""Wall seconds between two updates of the line on a terminal."""


def check(args: argparse.Namespace) -> int:
    """Check an experiment; return the exit code."""
    plan = _checked(args)
    about = _about(plan)
    if args.json:
        show_json(about)
    else:
        show(_said(plan))
    return ExitCode.DONE


def run(args: argparse.Namespace) -> int:
    """Make the runs of an experiment; return the exit code."""
    make, workers = factory_of(args.executor, args.jobs)
    plan = _checked(args)
    folder = args.output or Path(plan.file.name)
    with Results.create(folder, plan) as results:
        teller = _JsonLines() if args.json else _Lines(folder)
        campaign = Campaign(plan, results, make, workers, teller.tell)
        if campaign.progress.done and not args.json:
            warn(f"{folder}: goes on; {campaign.progress.done} of {campaign.progress.expected} runs have results")
        try:
            progress = campaign.run()
        except KeyboardInterrupt:
            teller.end(campaign.progress, {})
            done = f"{campaign.progress.done:,} of {campaign.progress.expected:,} runs have results"
            warn(f"interrupted; {done}, and the same command goes on")
            return ExitCode.INTERRUPTED
        comparisons = campaign.comparisons()
        teller.end(progress, comparisons)
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


def _about(plan: Plan) -> dict[str, object]:
    replications = plan.file.replications
    return {
        "name": plan.file.name,
        "hash": plan.hash,
        "scenarios": len(plan.scenarios),
        "treatments": [*plan.treatments],
        "replications": {"min": replications.min, "max": replications.max},
        "runs": {"min": _runs(plan, replications.min), "max": _runs(plan, replications.max)},
        "measures": [*plan.file.measures],
    }


def _runs(plan: Plan, replications: int) -> int:
    return len(plan.scenarios) * len(plan.treatments) * replications


def _said(plan: Plan) -> str:
    replications = plan.file.replications
    least, most = (
        _runs(plan, replications.min if replications.until else replications.max),
        _runs(plan, replications.max),
    )
    count = f"{most:,} runs" if least == most else f"{least:,} to {most:,} runs"
    scenarios, treatments = len(plan.scenarios), len(plan.treatments)
    return (
        f"{plan.file.name}: {count}: {scenarios} scenario{'s' * (scenarios != 1)}, "
        f"{treatments} treatment{'s' * (treatments != 1)} ({', '.join(plan.treatments)})"
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
    """Return why there are so many replications, where a verdict decides that."""
    until, pairs = plan.file.replications.until, comparison.difference.n
    first, measure = next(iter(plan.treatments)), until.measure if until else ""
    after = f"{pairs:,}" if comparison.decided_after is None else f"{comparison.decided_after:,} of {pairs:,}"
    text = f"{measure} of {name} compared with {first}: {comparison.verdict} after {after} pairs"
    return f"{text}; {withdrawal(comparison)}" if comparison.withdrawn else text


class _Lines:
    """Tells how far it is, on one line of a terminal or once a minute, and of the first run that crashed or hung."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._line = TerminalLine()
        self._told = 0.0 if self._line.shown else time.monotonic()
        self._mishap_told = False

    def tell(self, progress: Progress) -> None:
        """Tell, if it was not just told."""
        if progress.mishap is not None and not self._mishap_told:
            self._mishap_told = True
            self._tell_mishap(progress.mishap)
        if time.monotonic() - self._told >= (_LOOK if self._line.shown else _MINUTE):
            self._told = time.monotonic()
            self._line.tell(_text(progress))

    def end(self, _progress: Progress, _comparisons: Mapping[str, Comparison]) -> None:
        """Take the line away."""
        self._line.show()

    def _tell_mishap(self, row: Row) -> None:
        self._line.show()
        cause = f": {row.cause}" if row.cause else ""
        warn(f"warning: run {row.run.number} ({row.run.treatment}) {row.ending}{cause}")
        warn(f"  hmrsim experiment show {self._folder} {row.run.number}")


class _JsonLines:
    """Tells how far it is as JSON."""

    def tell(self, progress: Progress) -> None:
        """Write a line."""
        show_json(_counts(progress))

    def end(self, progress: Progress, comparisons: Mapping[str, Comparison]) -> None:
        """Write the last line."""
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
