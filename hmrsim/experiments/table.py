"""The table of runs for other programs: CSV, JSON, Parquet."""

from __future__ import annotations

import csv
import importlib
import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, TextIO

from hmrsim.diagnostics import known_name
from hmrsim.errors import MissingExtra, OutputError, reason_of
from hmrsim.experiments.repeats import COLUMNS, Repeats, counted
from hmrsim.experiments.statistics.intervals import Interval, mean_interval, proportion_interval

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.experiments.store import Results

FORMATS = (".csv", ".json", ".parquet")
"""The supported suffixes of files."""


def write_table(results: Results, path: Path) -> None:
    """Write all runs, in order of their numbers.

    Raises:
        OutputError: The file can't be written, or is of no known format.
        MissingExtra: Parquet needs pyarrow, which is not installed.
    """
    kind = path.suffix.lower()
    if kind not in FORMATS:
        raise OutputError(f"{path}: is of no known format; expected one of {', '.join(FORMATS)}")
    try:
        if kind == ".parquet":
            _write_parquet(results, path)
            return
        with path.open("w", encoding="utf-8", newline="") as file:
            write_csv(results, file) if kind == ".csv" else write_json(results, file)
    except OSError as error:
        raise OutputError(f"{path}: can't be written: {reason_of(error)}") from None


def write_csv(results: Results, file: TextIO) -> None:
    """Write all runs as CSV, with empty fields for missing values."""
    writer = csv.DictWriter(file, results.columns(), lineterminator="\n")
    writer.writeheader()
    writer.writerows(results.rows())


def write_json(results: Results, file: TextIO) -> None:
    """Write all runs as one JSON list, with one run per line."""
    begin = "["
    for row in results.rows():
        file.write(f"{begin}\n{json.dumps(_plain(row))}")
        begin = ","
    file.write("]\n" if begin == "," else "[]\n")


def _plain(row: dict[str, Any]) -> dict[str, Any]:
    return {**row, "success": bool(row["success"]), "reported": json.loads(row["reported"])}


def _write_parquet(results: Results, path: Path) -> None:
    try:
        arrow: Any = importlib.import_module("pyarrow")
        parquet: Any = importlib.import_module("pyarrow.parquet")
    except ImportError:
        raise MissingExtra("Parquet needs pyarrow; install hmrsim[parquet]") from None
    table = arrow.Table.from_pylist([*results.rows()])
    parquet.write_table(table, path)


_RUNS: Final = ""
"""The key for all runs among the names of measures."""


@dataclass
class Group:
    """The runs of a treatment, or of a treatment at certain levels of factors.

    Attributes:
        name: The treatment.
        values: The values of each measure, in order of the runs' numbers, without missing values.
        levels: The levels of the factors by which the runs are grouped.
        failed: The number of values of each measure from runs without success.
    """

    name: str
    runs: int = 0
    successes: int = 0
    endings: Counter[str] = field(default_factory=Counter)
    values: dict[str, list[float]] = field(default_factory=dict)
    levels: Mapping[str, Any] = field(default_factory=dict)
    failed: Counter[str] = field(default_factory=Counter)
    _squares: Counter[str] = field(default_factory=Counter)

    def add(self, row: Mapping[str, Any], square: int) -> None:
        """Add a run with its measures; *square* is that of `Repeats.weighed`."""
        self.runs += 1
        self.successes += row["success"]
        self.endings[row["ending"]] += 1
        self._squares[_RUNS] += square
        for measure, values in self.values.items():
            if isinstance(row[measure], (int, float)):
                values.append(row[measure])
                self.failed[measure] += not row["success"]
                self._squares[measure] += square

    @property
    def count(self) -> int:
        """The effective number of runs, of which some may be the same."""
        return counted(self.runs, self._squares[_RUNS])

    def rate(self) -> Interval:
        """Return the rate of success, with Wilson's interval."""
        return share_of(self.successes, self.runs, self.count)

    def mean(self, measure: str) -> Interval:
        """Return the mean of a measure; see `interval_of`."""
        values = self.values[measure]
        return interval_of(values, counted(len(values), self._squares[measure]))


def share_of(successes: float, runs: int, count: int) -> Interval:
    """Return a share of runs with Wilson's interval for an effective number of runs."""
    return proportion_interval(successes if count == runs else count * (successes / runs), count)


def interval_of(values: Sequence[float], count: int) -> Interval:
    """Return the mean with Student's interval, or with Wilson's if all values are 0 or 1.

    Student's interval would reach below 0 or beyond 1 if one of both is rare. *count* is the effective
    number of values; see `counted`.
    """
    if {*values} == {0.0, 1.0}:
        return share_of(sum(values), len(values), count)
    return mean_interval(values, n=count)


def groups_by(results: Results, factors: Sequence[str] = ()) -> list[Group]:
    """Return the results of each treatment, under each combination of levels of *factors*, in order of the levels.

    Raises:
        ValueError: The experiment has no such factor.
    """
    known, measures = results.about["factors"], results.about["measures"]
    for factor in factors:
        known_name("factor", factor, known)
    order = [*results.about["treatments"]]

    def empty(name: str, levels: Mapping[str, Any]) -> Group:
        return Group(name, values={each: [] for each in measures}, levels=levels)

    groups: dict[tuple[Any, ...], Group] = {} if factors else {(name,): empty(name, {}) for name in order}
    rows = results.rows([*COLUMNS, *factors, "ending", "success", *measures])
    for row, square in Repeats.of(results.rows(COLUMNS)).weighed(rows):
        levels = {factor: row[factor] for factor in factors}
        key = (row["treatment"], *levels.values())
        if key not in groups:
            groups[key] = empty(row["treatment"], levels)
        groups[key].add(row, square)

    def place(group: Group) -> tuple[Any, ...]:
        levels = group.levels.values()
        return (*((isinstance(level, str), level) for level in levels), order.index(group.name))

    return sorted(groups.values(), key=place)
