"""What a worker does: some runs, one after the other, each within its limits."""

from __future__ import annotations

import ctypes
import multiprocessing
import os
import signal
import sys
import time
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Final

from hmrsim.errors import ExperimentError, Problem
from hmrsim.experiments.file.reading import read_plan
from hmrsim.experiments.judging.labels import ERROR, HUNG, MEMORY
from hmrsim.experiments.results.row import Row
from hmrsim.experiments.running.commands import run_command
from hmrsim.experiments.running.controlling import TimeLimit
from hmrsim.experiments.running.guards import guarded
from hmrsim.experiments.running.single import run_in_process, unwatched
from hmrsim.program.garbage import collect_rarely
from hmrsim.program.users_code import described

if TYPE_CHECKING:
    from hmrsim.experiments.file.plan import Plan, Run
    from hmrsim.experiments.running.single import Watchers

_PR_SET_PDEATHSIG: Final = 1
"""Of Linux's prctl: a signal when the process that has started this one dies, however it does."""


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


def prepare_worker() -> None:
    """Make a process of a pool ready: it says nothing, leaves Ctrl-C to its parent, and ends with that."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform == "linux":
        ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)
    parent = multiprocessing.parent_process()
    if parent is not None and parent.pid != os.getppid():
        os._exit(1)  # it has died before
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    collect_rarely()


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
            make = run_in_process if plan.treatments[run.treatment].in_process else run_command
            row = make(plan, run, further)
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
