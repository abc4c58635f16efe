"""The schedule of runs: replication by replication, until each scenario has enough."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Mapping, Sequence
from contextlib import suppress
from statistics import fmean
from typing import TYPE_CHECKING, Final

from hmrsim.experiments.results.repeats import Repeats, about_means, pairs_that_count
from hmrsim.experiments.statistics.stopping import MEAN, PROPORTION, StoppingRule, enough
from hmrsim.experiments.statistics.verdicts import UNDECIDED, Comparison, Criterion, compare, verdict

if TYPE_CHECKING:
    from hmrsim.experiments.file.model import Until
    from hmrsim.experiments.file.plan import Plan, Run
    from hmrsim.experiments.measures import Value

_LEAST: Final = 3
"""The minimum number of replications for a mean: the spread of fewer is hardly known."""
_GROWTH: Final = 0.25
"""The share by which the number of replications grows at once."""


class Schedule:
    """The runs of a plan that remain to be made.

    They depend only on the results of whole replications, and not on the order in which results arrive.

    Args:
        plan: The experiment.
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

    def _criterion(self, until: Until) -> Criterion:
        measure = self._plan.file.measures[until.measure]
        alpha = (1.0 - until.confidence) / (len(self._plan.treatments) - 1)
        return Criterion(measure.better == "larger", measure.margin or None, relative=measure.relative, alpha=alpha)

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
        one: list[float] = []
        two: list[float] = []
        groups = pairs_that_count([(run.scenario, run.replication) for run, _ in runs], repeated)
        for places in groups:
            means = [self._mean([runs[place][side] for place in places]) for side in (0, 1)]
            if means[0] is not None and means[1] is not None:
                one.append(means[0])
                two.append(means[1])
        return one, two, about_means(self._criterion(until), groups)

    def _mean(self, runs: Sequence[Run]) -> float | None:
        """Return the mean of runs; None if one has no value."""
        values = [self._done[run.number] for run in runs]
        known = [float(value) for value in values if isinstance(value, (int, float))]
        return fmean(known) if len(known) == len(runs) else None

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
