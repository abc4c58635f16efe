"""What a worker does: some runs, one after the other, each within its limits."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

from hmrsim.errors import ExperimentError, Problem
from hmrsim.experiments.file.reading import read_plan
from hmrsim.experiments.results.row import Row
from hmrsim.experiments.running.single import row_of
from hmrsim.program.users_code import described
from hmrsim.trials.endings import ERROR, HUNG, MEMORY, TimeLimit
from hmrsim.trials.guards import guarded
from hmrsim_zenoh.hosting.served_simulation import Watchers, unwatched

if TYPE_CHECKING:
    from hmrsim.experiments.file.plan import Plan, Run


@dataclass(frozen=True)
class Task:
    """Some runs of an experiment.

    Attributes:
        path: The experiment's file; a worker on another machine needs to see it, too.
        variant: The variants that were chosen.
        hash: The hash of the plan that is meant.
        numbers: The numbers of the runs.
    """

    path: str
    variant: tuple[str, ...]
    hash: str
    numbers: tuple[int, ...]


def execute(task: Task) -> list[Row]:
    """Return the results of some runs, in order.

    Raises:
        ExperimentError: The file can't be read any more, or has changed.
    """
    plan = _plan(task.path, task.variant, task.hash)
    return [execute_run(plan, run) for number in task.numbers if (run := plan.run_of(number)) is not None]


def execute_run(plan: Plan, run: Run, further: Watchers = unwatched) -> Row:
    """Return the result of a run, whatever happens in it; *further* makes further sinks."""
    began = time.perf_counter()
    try:
        with guarded(plan.file.limits) as tail:
            row = row_of(plan, run, further)
    except TimeLimit as limit:
        return Row(run, HUNG, str(limit), wall=time.perf_counter() - began, output=tail.text)
    except MemoryError:
        return Row(run, MEMORY, "it takes more memory than its limit", output=tail.text)
    except Exception as error:  # noqa: BLE001 - one of ours: the other runs must not suffer
        return Row(run, ERROR, described(error), output=tail.text)
    return replace(row, output=row.output or tail.text)


@lru_cache(maxsize=4)
def _plan(path: str, variant: tuple[str, ...], hash_: str) -> Plan:
    plan = read_plan(path, variant)
    if plan.hash != hash_:
        raise ExperimentError([Problem(path, "", "has changed since the experiment was started; start it again")])
    return plan
