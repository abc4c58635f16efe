"""One run of an experiment: a trial, and the judge."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from bt_controller.coverage import TreeCoverage
from hmrsim.errors import HmrsimError
from hmrsim.experiments.judging.endings import Judge
from hmrsim.experiments.judging.fingerprint import fingerprint_of
from hmrsim.experiments.judging.measures import measures_of, needs_report
from hmrsim.experiments.results.row import Row
from hmrsim.experiments.running.coverages import packed
from hmrsim.report.sink import LiveReport
from hmrsim.settings.run import RunSettings
from hmrsim.trace.deferred import DeferredTrace
from hmrsim.trials.controllers import trial_of
from hmrsim.trials.endings import CRASHED, ERROR, FAILED, SUCCEEDED, TIMEOUT
from hmrsim_zenoh.hosting.served_simulation import Watchers, unwatched

if TYPE_CHECKING:
    from hmrsim.experiments.file.plan import Plan, Run
    from hmrsim.protocol.sinks import Sink
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.timing.pacing import Pacing


def row_of(plan: Plan, run: Run, further: Watchers = unwatched) -> Row:
    """Return the result of a run, with its trace if it may be kept.

    A command is started in the folder of the experiment with ``HMRSIM_CONNECT``, ``HMRSIM_SEED`` and ``HMRSIM_RUN`` in
    its environment. *further* makes further sinks, such as one that records the run.
    """
    began = time.perf_counter()
    treatment = plan.treatments[run.treatment]
    coverage = TreeCoverage() if plan.file.keep.coverage and treatment.in_process else None
    settings = RunSettings(seed=run.seed, duration=plan.file.limits.simulated, clock="lockstep")
    judge = Judge(plan.file.ends)
    try:
        loaded = plan.world(run.scenario, run.treatment)
        trace = DeferredTrace(loaded.world, settings)
        report = LiveReport(loaded.world, settings) if needs_report(plan.file) else None
        trial = trial_of(
            loaded,
            settings,
            treatment,
            plan.path.parent,
            names=plan.names(run.scenario),
            variables={"HMRSIM_RUN": str(run.number)},
            coverage=coverage,
            sinks=[trace, judge] if needs_trace(plan) else [judge],
            watchers=with_report(report, further),
        )
    except (HmrsimError, ValueError) as error:
        return Row(run, ERROR, str(error), wall=time.perf_counter() - began)
    with trial:
        simulator = trial.simulator
        judge.watch(simulator, trial.end)
        try:
            ending, cause, output = trial.play()
        except HmrsimError as error:
            return Row(run, ERROR, str(error), wall=time.perf_counter() - began)
        # What the judge has found counts, and so does the limit, also where a controller is confused by the end.
        if ending == CRASHED and trial.over and treatment.in_process:
            ending, cause = TIMEOUT, ""
        elif ending in {SUCCEEDED, FAILED}:
            if not trial.over:
                judge.controller_ended(succeeded=ending == SUCCEEDED, now=simulator.now)
            ending = TIMEOUT
        judged = bool(judge.label)
        judge.end(ending, simulator.now)
        values = (lambda: report.report(simulator).model_dump(mode="json")) if report else dict
        row = result_of(plan, run, judge, simulator, values)
    return replace(
        with_trace(plan, row, trace, simulator),
        cause="; ".join(filter(None, ["" if judged else cause, row.cause])),
        wall=time.perf_counter() - began,
        coverage=packed(coverage) if coverage is not None and coverage.trees else b"",
        output=output,
    )


def needs_trace(plan: Plan) -> bool:
    """Return whether the trace of a run may be kept, or compared with those of other replications."""
    return plan.file.keep.traces != "none" or plan.file.replications.max > 1


def with_trace(plan: Plan, row: Row, trace: DeferredTrace, simulator: Simulator) -> Row:
    """Return the result of a run with its trace, if that is kept, and its fingerprint, if others may have the same."""
    keeps = plan.file.keep.traces == "all" or (plan.file.keep.traces == "failed" and not row.success)
    compares = plan.file.replications.max > 1 and not simulator.chance.used
    text = trace.whole(simulator.now) if keeps or compares else ""
    result = row.ending, row.at, dict(row.measures), dict(row.reported)
    return replace(row, trace=text if keeps else "", fingerprint=fingerprint_of(text, *result) if compares else "")


def with_report(report: LiveReport | None, further: Watchers) -> Watchers:
    """Return what makes the sinks of a run: that of its report, if there is one, and further ones."""

    def watchers(simulator: Simulator, pacing: Pacing) -> Sequence[Sink]:
        return [*([report.sink(simulator)] if report else []), *further(simulator, pacing)]

    return watchers


def result_of(plan: Plan, run: Run, judge: Judge, simulator: Simulator, report: Callable[[], Mapping[str, Any]]) -> Row:
    """Return the result of a run that was judged; its cause says which measures have no value, and why."""
    measures, flaws = measures_of(plan.file, judge, simulator, report)
    return Row(
        run,
        judge.label,
        "; ".join(filter(None, [judge.cause, *flaws])),
        judge.label in plan.file.successes,
        judge.at,
        measures=measures,
        reported=judge.reported,
    )
