"""Results by treatment: rates of success and means, with intervals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hmrsim.experiments.statistics.intervals import Interval, mean_interval, proportion_interval

if TYPE_CHECKING:
    from hmrsim.experiments.results.store import Results


@dataclass
class Group:
    """The runs of a treatment.

    Attributes:
        endings: How many runs ended in which way.
        values: The values of each measure, in order of the runs' numbers; without those that have none.
    """

    name: str
    runs: int = 0
    successes: int = 0
    endings: Counter[str] = field(default_factory=Counter)
    values: dict[str, list[float]] = field(default_factory=dict)

    def rate(self) -> Interval:
        """Return the rate of success, with Wilson's interval."""
        return proportion_interval(self.successes, self.runs)

    def mean(self, measure: str) -> Interval:
        """Return the mean of a measure, with Student's interval."""
        return mean_interval(self.values[measure])


def groups_of(results: Results, rows: Iterable[Mapping[str, Any]] | None = None) -> dict[str, Group]:
    """Return the treatments of an experiment with their results."""
    measures = [*results.about["measures"]]
    groups = {name: Group(name, values={each: [] for each in measures}) for name in results.about["treatments"]}
    columns = ["treatment", "ending", "success", *measures]
    for row in results.rows(columns) if rows is None else rows:
        group = groups[row["treatment"]]
        group.runs += 1
        group.successes += row["success"]
        group.endings[row["ending"]] += 1
        for measure in measures:
            if isinstance(row[measure], (int, float)):
                group.values[measure].append(row[measure])
    return groups
