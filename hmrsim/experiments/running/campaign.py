"""A campaign: all runs of an experiment on an executor, which continues even if single runs are lost."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from hmrsim.experiments.results.store import Row
from hmrsim.experiments.running.replications import Coverages, Task, execute
from hmrsim.experiments.running.schedule import Schedule
from hmrsim.experiments.statistics.summaries import distributions
from hmrsim.trials.batches import Batches
from hmrsim.trials.guards import ending_of_lost
from hmrsim.trials.trial import MISHAPS

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

    from hmrsim.experiments.file.plan import Plan, Run
    from hmrsim.experiments.results.store import Results
    from hmrsim.experiments.statistics.verdicts import Comparison

_TASK_SECONDS: Final = 0.3
"""The wall seconds that the runs of one task should take; sending a task costs half a millisecond."""
_MAX_CHUNK: Final = 64
_START: Final = 2.0
"""Wall seconds in which workers start."""
_UNKNOWN: Final = 16
"""The number of concurrent tasks on a cluster of unknown size."""


@dataclass
class Progress:
    """The progress of an experiment.

    Attributes:
        done: Runs with a result.
        expected: The total number of runs, as far as it is known.
        made: The number of runs that this process made.
        failed: The number of these without success, by ending.
        mishap: The first run that crashed, hung or ended by another mishap; None if there is none yet.
        began: The time of the start, by the monotonic clock.
    """

    done: int = 0
    expected: int = 0
    made: int = 0
    failed: Counter[str] = field(default_factory=Counter)
    mishap: Row | None = None
    began: float = field(default_factory=time.monotonic)

    @property
    def seconds_left(self) -> float | None:
        """Wall seconds until the end at the current pace; None while workers start."""
        passed = time.monotonic() - self.began
        if not self.made or passed < _START:
            return None
        return (self.expected - self.done) * passed / self.made


class Campaign:
    """Makes the runs of a plan that have no result yet.

    Args:
        plan: The experiment.
        results: The store that receives each result.
        make: Creates an executor; called again when one breaks.
        workers: The number of runs that it executes at the same time; 0 if unknown.
        tell: Called whenever there are new results.

    Raises:
        MissingExtra: The number of replications depends on statistics that are not installed.
    """

    def __init__(
        self,
        plan: Plan,
        results: Results,
        make: Callable[[], Executor],
        workers: int,
        tell: Callable[[Progress], None] = lambda _progress: None,
    ) -> None:
        self._plan, self._results, self._tell = plan, results, tell
        until = plan.file.replications.until
        if until:
            distributions()  # report missing libraries before the first run
        measure = until.measure if until else "seed"
        rows = results.rows(["number", measure, "fingerprint"])
        done = {int(row["number"]): (row[measure], row["fingerprint"]) for row in rows}
        self._schedule = Schedule(plan, done)
        self._coverages = Coverages(results)
        self._workers = workers or _UNKNOWN
        self._batches = Batches(make, self._workers)
        self._chunk = 1
        self.progress = Progress(self._schedule.done, self._schedule.expected)

    def comparisons(self) -> dict[str, Comparison]:
        """Return the comparisons with the first treatment that decide the number of replications."""
        return self._schedule.comparisons()

    def run(self) -> Progress:
        """Execute all runs; return the final progress.

        Raises:
            WriteError: Results can't be written.
            OutputError: The file of a coverage can't be written.
            ExperimentError: The file has changed during the campaign.
        """
        with self._results.writing(), ExitStack() as ending:
            ending.callback(self._coverages.write)
            try:
                for _, rows in self._batches.results(self._next, self._submit, self._lost):
                    self._note(rows)
            except BaseException:
                self._batches.stop()
                raise
            self._batches.close()
        return self.progress

    def _next(self) -> list[Run]:
        return self._schedule.next(self._chunk)

    def _submit(self, executor: Executor, runs: Sequence[Run]) -> Future[list[Row]]:
        plan = self._plan
        return executor.submit(
            execute, Task(str(plan.path), plan.variant, plan.hash, tuple(run.number for run in runs))
        )

    def _lost(self, run: Run, seconds: float) -> Row:
        return Row(run, *ending_of_lost(self._plan.file.limits, seconds), wall=seconds)

    def _note(self, rows: list[Row]) -> None:
        if not rows:
            return
        self._results.add(self._plan, rows, self._coverages.take(rows))
        measure = self._schedule.measure
        for row in rows:
            self._schedule.note(row.run, row.measures.get(measure) if measure else None, row.fingerprint)
        progress = self.progress
        progress.done, progress.expected = self._schedule.done, self._schedule.expected
        progress.made += len(rows)
        progress.failed.update(row.ending for row in rows if not row.success)
        mishaps = (row for row in rows if row.ending in MISHAPS and not row.success)
        progress.mishap = progress.mishap or next(mishaps, None)
        pace = sum(row.wall for row in rows) / len(rows)
        self._chunk = max(1, min(_MAX_CHUNK, int(_TASK_SECONDS / max(pace, 1e-3))))
        left = (progress.expected - progress.done) // self._batches.most
        self._chunk = max(1, min(self._chunk, left))
        self._tell(progress)
