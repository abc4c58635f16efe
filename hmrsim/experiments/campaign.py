"""A campaign: all runs of an experiment on an executor, replication by replication until each scenario has enough."""

from __future__ import annotations

import math
import time
from collections import Counter, deque
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Final

from hmrsim.experiments.repeats import Repeats, about_means, means_of_pairs, pairs_that_count
from hmrsim.experiments.replications import Coverages, Task, execute
from hmrsim.experiments.statistics.intervals import MEAN, PROPORTION, StoppingRule, enough
from hmrsim.experiments.statistics.summaries import distributions
from hmrsim.experiments.statistics.verdicts import UNDECIDED, Comparison, Criterion, compare, verdict
from hmrsim.experiments.store import Row
from hmrsim.trials.batches import Batches
from hmrsim.trials.guards import ending_of_lost
from hmrsim.trials.trial import MISHAPS

if TYPE_CHECKING:
    from concurrent.futures import Executor, Future

    from hmrsim.experiments.measures import Value
    from hmrsim.experiments.model import Until
    from hmrsim.experiments.plan import Plan, Run
    from hmrsim.experiments.store import Results


_LEAST: Final = 3
"""The minimum number of replications for a mean: the spread of fewer is hardly known."""
_GROWTH: Final = 0.25
"""The share by which the number of replications grows at once."""


class Schedule:
    """The runs of a plan that remain to be made.

    They depend only on the results of whole replications, and not on the order in which results arrive.

    Args:
        done: The existing results: the value of the deciding measure and the fingerprint, by the number of the run.
    """

    def __init__(self, plan: Plan, done: Mapping[int, tuple[Value, str]]) -> None:
        self._plan = plan
        self._done: dict[int, Value] = {}
        self._repeats = Repeats()
        for number, (value, fingerprint) in done.items():
            if (run := plan.run_of(number)) is not None:
                self._done[number] = value
                self._repeats.note((run.scenario, run.treatment), fingerprint)
        replications = plan.file.replications
        self._until = replications.until
        first = replications.min if self._until else replications.max
        count = len(plan.scenarios)
        self._targets = [0] * count
        self._missing = [0] * count
        self._further: deque[Run] = deque()
        self._fresh = (
            plan.run(scenario, treatment, replication)
            for replication in range(first)
            for scenario in range(count)
            for treatment in plan.treatments
        )
        for scenario in range(count):
            self._aim(scenario, first)
        for scenario in range(count):
            self._extend(scenario)

    @property
    def measure(self) -> str | None:
        """The name of the measure that decides the number of replications; None for none."""
        return self._until.measure if self._until else None

    @property
    def expected(self) -> int:
        """The total number of runs, as far as it is known."""
        return sum(self._targets) * len(self._plan.treatments)

    @property
    def done(self) -> int:
        """The number of runs with a result."""
        return len(self._done)

    def next(self, most: int) -> list[Run]:
        """Return at most *most* runs to make next, the first replications of all scenarios first."""
        found: list[Run] = []
        while len(found) < most:
            run = self._further.popleft() if self._further else next(self._fresh, None)
            if run is None:
                break
            if run.number not in self._done:
                found.append(run)
        return found

    def note(self, run: Run, value: Value, fingerprint: str = "") -> None:
        """Record the result of a run."""
        self._repeats.note((run.scenario, run.treatment), fingerprint)
        if run.number not in self._done and run.replication < self._targets[run.scenario]:
            self._missing[run.scenario] -= 1
        self._done[run.number] = value
        self._extend(run.scenario)

    def _aim(self, scenario: int, target: int) -> list[Run]:
        """Raise the number of replications of a scenario; return the additional runs."""
        runs = [
            run
            for replication in range(self._targets[scenario], target)
            for treatment in self._plan.treatments
            if (run := self._plan.run(scenario, treatment, replication)).number not in self._done
        ]
        self._targets[scenario] = target
        self._missing[scenario] += len(runs)
        return runs

    def _extend(self, scenario: int) -> None:
        """Add replications to scenarios whose runs all have results, until there are enough."""
        until = self._until
        if until is None:
            return
        together = [*range(len(self._targets))] if until.decided else [scenario]
        most = self._plan.file.replications.max
        while not any(self._missing[each] for each in together) and self._targets[scenario] < most:
            if self._decided(until) if until.decided else self._known(scenario):
                return
            target = self._targets[scenario]
            for each in together:
                self._further += self._aim(each, min(most, target + max(1, math.ceil(target * _GROWTH))))

    def _known(self, scenario: int) -> bool:
        """Return whether a scenario needs no further replications: its means are known, or its runs are repeated."""
        return all(
            self._repeats.repeats((scenario, treatment)) or self._enough(scenario, treatment)
            for treatment in self._plan.treatments
        )

    def comparisons(self) -> dict[str, Comparison]:
        """Return the comparisons with the first treatment, if they decide the number of replications; else nothing."""
        until = self._until
        if until is None or not until.decided:
            return {}
        first, *others = self._plan.treatments
        found = {}
        for other in others:
            with suppress(ValueError):  # as for `_decided`
                found[other] = compare(*self._compared(first, other, until))
        return found

    def _decided(self, until: Until) -> bool:
        """Return whether each treatment is known to be better or worse than the first one, or equivalent.

        If further replications would repeat the same runs, they add no information.
        """
        first, *others = self._plan.treatments
        if all(self._repeats.repeats((i, name)) for i in range(len(self._targets)) for name in self._plan.treatments):
            return True
        try:
            return all(verdict(*self._compared(first, other, until))[0] != UNDECIDED for other in others)
        except ValueError:  # a relative margin of a measure that is negative in some runs: nothing can be decided
            return False

    def _compared(self, first: str, second: str, until: Until) -> tuple[list[float], list[float], Criterion]:
        """Return the values of two treatments, in the order of `contrast`, and the criterion."""
        runs = [
            (self._plan.run(scenario, first, replication), self._plan.run(scenario, second, replication))
            for replication in range(max(self._targets))
            for scenario in range(len(self._targets))
        ]
        # In the order of the design, the verdict would depend on which level comes first.
        runs.sort(key=lambda pair: (pair[0].replication, pair[0].seed))
        runs = [pair for pair in runs if all(run.number in self._done for run in pair)]
        repeated = [all(self._repeats.repeats((run.scenario, run.treatment)) for run in pair) for pair in runs]
        groups = pairs_that_count([(run.scenario, run.replication) for run, _ in runs], repeated)
        one, two = ([self._done[pair[side].number] for pair in runs] for side in (0, 1))
        measure = self._plan.file.measures[until.measure]
        alpha = (1.0 - until.confidence) / (len(self._plan.treatments) - 1)
        about = Criterion(measure.better == "larger", measure.margin or None, relative=measure.relative, alpha=alpha)
        return *means_of_pairs(one, two, groups), about_means(about, groups)

    def _enough(self, scenario: int, treatment: str) -> bool:
        until = self._until
        if until is None:
            return True
        numbers = (self._plan.run(scenario, treatment, each).number for each in range(self._targets[scenario]))
        values = [value for number in numbers if isinstance(value := self._done[number], (int, float))]
        minimum = self._plan.file.replications.min
        error, of = (until.relative_error, MEAN) if until.relative_error is not None else (until.error, PROPORTION)
        if error is None:
            raise AssertionError
        rule = StoppingRule(error, of, until.confidence, max(_LEAST, minimum), look_ahead=0)
        return len(values) >= rule.minimum and enough(values, rule)


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
