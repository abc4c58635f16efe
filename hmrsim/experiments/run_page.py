"""The page of a run of an experiment, beside the run of another treatment in the same scenario and replication."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from hmrsim.experiments.replications import execute_run
from hmrsim.run_page import Heading, RunLog, ShownRun, page_of
from hmrsim.timing.pacing import Watchers, unwatched

if TYPE_CHECKING:
    from hmrsim.experiments.plan import Plan, Run
    from hmrsim.experiments.store import Row


def run_logged(plan: Plan, run: Run, further: Watchers = unwatched) -> tuple[Row, RunLog]:
    """Make a run; return its result and its log. *further* makes further sinks."""
    log = RunLog()
    return execute_run(plan, run, log.watchers(further), log.note_tick), log


def run_page(plan: Plan, row: Row, log: RunLog, beside: Run | None) -> str:
    """Return the page of a run that has begun; *beside* is a run to make and show beside it, if any."""
    run = row.run
    shown = [_shown(row, log)]
    if beside is not None:
        other, other_log = run_logged(plan, beside)
        if other_log.watched:
            shown.append(_shown(other, other_log))
    levels = "".join(f", {name} {value}" for name, value in plan.scenarios[run.scenario].items())
    alone = "There is no other run to compare it with."
    if len(shown) > 1:
        alone = f"Both runs have the same world and the same seed, {run.seed}. Only the treatment differs."
    heading = Heading(
        f"Run {run.number} of {plan.file.name}{levels}", f"{run.treatment}: {row.ending}", row.cause, alone
    )
    return page_of(heading, (), (shown[0], shown[1]) if len(shown) > 1 else (shown[0],))


def _shown(row: Row, log: RunLog) -> ShownRun:
    at = 0.0 if row.at is None else row.at
    measures = "".join(f", {name} {_text(value)}" for name, value in row.measures.items())
    return ShownRun(row.run.treatment, log, f"ends as {row.ending} at {at:.1f} s{measures}", at)


def _text(value: Any) -> str:
    return f"{value:.4g}" if isinstance(value, float) else str(value)
