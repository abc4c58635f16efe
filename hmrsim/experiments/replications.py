"""One run of an experiment: a trial, its judge, and its result."""

from __future__ import annotations

import json
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Final

from bt_controller.coverage import TreeCoverage
from bt_controller.coverage.files import write_coverage
from hmrsim.errors import ExperimentError, Problem
from hmrsim.experiments.endings import Judge
from hmrsim.experiments.measures import measures_of, needs_report
from hmrsim.experiments.reading import read_plan
from hmrsim.experiments.repeats import fingerprint_of
from hmrsim.experiments.store import Row
from hmrsim.report.sink import LiveReport
from hmrsim.settings.run import RunSettings
from hmrsim.timing.pacing import Watchers, unwatched
from hmrsim.trace.writer import DeferredTrace
from hmrsim.trials.controllers import trial_of
from hmrsim.trials.guards import attempt
from hmrsim.trials.trial import CRASHED, FAILED, SUCCEEDED, TIMEOUT

if TYPE_CHECKING:
    from hmrsim.experiments.plan import Plan, Run
    from hmrsim.experiments.store import Results
    from hmrsim.protocol.sinks import Sink
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing
    from hmrsim.trials.controllers import OnTick
    from hmrsim.trials.trial import Trial


def _row_of(plan: Plan, run: Run, further: Watchers = unwatched, on_tick: OnTick | None = None) -> Row:
    """Return the result of a run, with its trace if it may be kept.

    A command is started in the folder of the experiment with ``HMRSIM_CONNECT``, ``HMRSIM_SEED`` and ``HMRSIM_RUN`` in
    its environment.

    Raises:
        HmrsimError: The world is invalid, or the controller can't be started.
        ValueError: An expression has no value.
    """
    treatment = plan.treatments[run.treatment]
    coverage = TreeCoverage() if plan.file.keep.coverage and treatment.in_process else None
    settings = RunSettings(seed=run.seed, duration=plan.file.limits.simulated, clock="lockstep")
    traces, several = plan.file.keep.traces, plan.file.replications.max > 1
    cell = run.scenario, run.treatment
    # A trace is compared with those of other replications unless the run draws random numbers, as the last one did.
    known = cell in plan.left_to_chance and treatment.in_process and further is unwatched
    traced = traces != "none" or (several and not known)
    judge = Judge(plan.file.ends)
    loaded = plan.world(run.scenario, run.treatment)
    trace = DeferredTrace(loaded.world, settings)
    report = LiveReport(loaded.world, settings) if needs_report(plan.file) else None

    def watchers(simulator: Simulator, pacing: Pacing) -> Sequence[Sink]:
        return [*([report.sink(simulator)] if report else []), *further(simulator, pacing)]

    trial = trial_of(
        loaded,
        settings,
        treatment,
        plan.path.parent,
        names=plan.names(run.scenario),
        variables={"HMRSIM_RUN": str(run.number)},
        coverage=coverage,
        sinks=[trace, judge] if traced else [judge],
        watchers=watchers,
        on_tick=on_tick,
    )
    simulator = trial.simulator
    with trial:
        cause, output = _play(trial, judge, in_process=treatment.in_process)
        values = (lambda: report.report(simulator).model_dump(mode="json")) if report else dict
        measures, flaws = measures_of(plan.file, judge, simulator, values)
    if simulator.chance.used:
        plan.left_to_chance.add(cell)
    elif several and not traced:
        plan.left_to_chance.discard(cell)
        return _row_of(plan, run, further, on_tick)
    success, result = judge.label in plan.file.successes, (judge.label, judge.at, measures, dict(judge.reported))
    # The trace includes the end of the trial.
    keeps = traces == "all" or (traces == "failed" and not success)
    compares = several and not simulator.chance.used
    text = trace.whole(simulator.now) if keeps or compares else ""
    return Row(
        run,
        judge.label,
        "; ".join(filter(None, [cause, judge.cause, *flaws])),
        success,
        judge.at,
        measures=measures,
        reported=judge.reported,
        output=output,
        trace=text if keeps else "",
        fingerprint=fingerprint_of(text, *result) if compares else "",
        coverage=packed(coverage) if coverage is not None and coverage.trees else b"",
    )


def _play(trial: Trial, judge: Judge, *, in_process: bool) -> tuple[str, str]:
    """Run the controller of a trial and judge its ending.

    Returns:
        The cause of the ending, unless the judge has ended the run before, and the output of the controller.
    """
    judge.watch(trial.simulator, trial.end)
    ending, cause, output = trial.play()
    now = trial.simulator.now
    # The verdict of the judge and the time limit take precedence, even if the end confuses a controller.
    if ending == CRASHED and trial.over and in_process:
        ending, cause = TIMEOUT, ""
    elif ending in {SUCCEEDED, FAILED}:
        if not trial.over:
            judge.controller_ended(succeeded=ending == SUCCEEDED, now=now)
        ending = TIMEOUT
    judged = bool(judge.label)
    judge.end(ending, now)
    return "" if judged else cause, output


@dataclass(frozen=True)
class Task:
    """Some runs of an experiment.

    Attributes:
        path: The experiment's file, which workers on other machines have to see as well.
    """

    path: str
    variant: tuple[str, ...]
    hash: str
    numbers: tuple[int, ...]


def execute(task: Task) -> list[Row]:
    """Return the results of the runs of a task, in order.

    Raises:
        ExperimentError: The file can't be read, or has changed.
    """
    plan = _plan(task.path, task.variant, task.hash)
    return [execute_run(plan, run) for number in task.numbers if (run := plan.run_of(number)) is not None]


def execute_run(plan: Plan, run: Run, further: Watchers = unwatched, on_tick: OnTick | None = None) -> Row:
    """Return the result of a run, whatever happens in it.

    *further* makes further sinks, such as one that records the run, and *on_tick* is called after each tick of a tree.
    """
    row, output, wall = attempt(plan.file.limits, lambda: _row_of(plan, run, further, on_tick), partial(Row, run))
    return replace(row, output=row.output or output, wall=wall)


@lru_cache(maxsize=4)
def _plan(path: str, variant: tuple[str, ...], hash_: str) -> Plan:
    plan = read_plan(path, variant)
    if plan.hash != hash_:
        raise ExperimentError([Problem(path, "", "has changed since the experiment was started; start it again")])
    return plan


FILE: Final = "coverage_{}.json"
"""The name of the file of a treatment in the folder of results."""


def packed(coverage: TreeCoverage) -> bytes:
    """Return a coverage as compressed bytes."""
    return zlib.compress(json.dumps(coverage.to_json(), separators=(",", ":")).encode())


def unpacked(coverage: bytes) -> TreeCoverage:
    """Return the coverage that `packed` compressed."""
    return TreeCoverage.from_json(zlib.decompress(coverage))


class Coverages:
    """The coverage of each treatment, including runs of earlier processes."""

    def __init__(self, results: Results) -> None:
        self._folder = results.folder
        self._found = {treatment: unpacked(coverage) for treatment, coverage in results.coverages().items()}

    def take(self, rows: Sequence[Row]) -> dict[str, bytes]:
        """Add the coverage of runs; return the total of their treatments, to be stored with the rows."""
        covered = [row for row in rows if row.coverage]
        for row in covered:
            self._found.setdefault(row.run.treatment, TreeCoverage()).merge(unpacked(row.coverage))
        return {
            treatment: packed(self._found[treatment]) for treatment in sorted({row.run.treatment for row in covered})
        }

    def write(self) -> None:
        """Write a file for each treatment.

        Raises:
            OutputError: It can't be written.
            WriteError: The disk is full.
        """
        for treatment, coverage in self._found.items():
            write_coverage("coverage", self._folder / FILE.format(treatment), coverage)
