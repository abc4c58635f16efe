"""Results by treatment, and by levels of factors: rates of success and means, with intervals."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import known_name
from hmrsim.experiments.statistics.intervals import Interval, mean_interval, proportion_interval

if TYPE_CHECKING:
    from hmrsim.experiments.results.store import Results


@dataclass
class Group:
    """The runs of a treatment, or of one under certain levels of factors.

    Attributes:
        name: The treatment.
        endings: How many runs ended in which way.
        values: The values of each measure, in order of the runs' numbers; without those that have none.
        levels: The levels of the factors by which the runs are grouped.
    """

    name: str
    runs: int = 0
    successes: int = 0
    endings: Counter[str] = field(default_factory=Counter)
    values: dict[str, list[float]] = field(default_factory=dict)
    levels: Mapping[str, Any] = field(default_factory=dict)

    def add(self, row: Mapping[str, Any]) -> None:
        """Count a run, with all measures that have values here."""
        self.runs += 1
        self.successes += row["success"]
        self.endings[row["ending"]] += 1
        for measure, values in self.values.items():
            if isinstance(row[measure], (int, float)):
                values.append(row[measure])

    def rate(self) -> Interval:
        """Return the rate of success, with Wilson's interval."""
        return proportion_interval(self.successes, self.runs)

    def mean(self, measure: str) -> Interval:
        """Return the mean of a measure; see `interval_of`."""
        return interval_of(self.values[measure])


def interval_of(values: Sequence[float]) -> Interval:
    """Return the mean with Student's interval; of a measure that is 0 in some runs and 1 in all others with Wilson's.

    Student's would reach below 0 or beyond 1 where one of both is rare.
    """
    if {*values} == {0.0, 1.0}:
        return proportion_interval(round(sum(values)), len(values))
    return mean_interval(values)


def groups_of(results: Results, rows: Iterable[Mapping[str, Any]] | None = None) -> dict[str, Group]:
    """Return the treatments of an experiment with their results."""
    measures = [*results.about["measures"]]
    groups = {name: Group(name, values={each: [] for each in measures}) for name in results.about["treatments"]}
    columns = ["treatment", "ending", "success", *measures]
    for row in results.rows(columns) if rows is None else rows:
        groups[row["treatment"]].add(row)
    return groups


def groups_by(results: Results, factors: Sequence[str]) -> list[Group]:
    """Return the results of each treatment under each combination of levels of *factors*, in order of the levels.

    Raises:
        ValueError: The experiment has no such factor.
    """
    known, measures = results.about["factors"], results.about["measures"]
    for factor in factors:
        known_name("factor", factor, known)
    groups: dict[tuple[Any, ...], Group] = {}
    for row in results.rows(["treatment", *factors, "ending", "success", *measures]):
        levels = {factor: row[factor] for factor in factors}
        key = (row["treatment"], *levels.values())
        if key not in groups:
            groups[key] = Group(row["treatment"], values={each: [] for each in measures}, levels=levels)
        groups[key].add(row)
    order = [*results.about["treatments"]]

    def place(group: Group) -> tuple[Any, ...]:
        levels = group.levels.values()
        return (*((isinstance(level, str), level) for level in levels), order.index(group.name))

    return sorted(groups.values(), key=place)
