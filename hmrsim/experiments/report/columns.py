"""The table of runs as NumPy columns, so that a hundred thousand runs take a few megabytes."""

from __future__ import annotations

from array import array
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hmrsim.experiments.repeats import COLUMNS, Repeats, cell_of
from hmrsim.experiments.report.model import Cause, Failure, Failures
from hmrsim.experiments.statistics.summaries import arrays

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from hmrsim.experiments.store import Results

    Numbers = NDArray[np.float64]
    Codes = NDArray[np.int64]
    Flags = NDArray[np.bool_]

MAX_LISTED: Final = 200
"""The maximum of listed runs without success, and of pairs that ended differently."""

_MAX_CAUSES: Final = 20
_MAX_CAUSE: Final = 300
"""The number of characters of a cause; causes that begin with the same characters count as one."""
_MOST: Final = 1e100
"""Larger values have no statistics."""
_FIXED: Final = (*COLUMNS, "number", "replication", "seed", "ending", "success", "cause")


@dataclass(frozen=True)
class Columns:
    """The runs in order of their numbers, with one value per run in each array.

    Attributes:
        treatment: The index of each run's treatment in *treatments*.
        ending: The index of its ending in *endings*.
        success: 1 or 0.
        factors: The index of the level of each factor in *levels*.
        measures: The values of each measure; NaN for none.
        squares: The contribution of each run to the squared weights; see `counted`.
        repeated: Whether all replications of its scenario and treatment are the same run.
        texts: The number of runs with a text for a measure.
    """

    treatments: Sequence[str]
    endings: Sequence[str]
    numbers: Codes
    scenario: Codes
    treatment: Codes
    replication: Codes
    seed: Codes
    ending: Codes
    success: Numbers
    factors: dict[str, Codes]
    levels: dict[str, list[Any]]
    measures: dict[str, Numbers]
    squares: Numbers
    repeated: Flags
    texts: Counter[str]
    failures: Failures

    def __len__(self) -> int:
        """Return the number of runs."""
        return len(self.numbers)

    def levels_of(self, run: int) -> dict[str, Any]:
        """Return the level of each factor in the run with an index."""
        return {name: self.levels[name][codes[run]] for name, codes in self.factors.items()}


def columns_of(results: Results) -> Columns:
    """Return the columns of the runs that have a result now."""
    about = results.about
    measures, factors = [*about["measures"]], [*about["factors"]]
    treatments = {name: number for number, name in enumerate(about["treatments"])}
    # The numbers of endings and levels, in order of their first use.
    endings: dict[str, int] = {}
    levels: dict[str, dict[Any, int]] = {name: {} for name in factors}
    whole = {name: array("q") for name in ("number", "scenario", "replication", "seed", "treatment", "ending")}
    codes = {name: array("q") for name in factors}
    values = {name: array("d") for name in ("success", *measures)}
    squares, repeated = array("d"), array("b")
    repeats = Repeats.of(results.rows(COLUMNS))
    texts: Counter[str] = Counter()
    failures = _Failing(factors)
    for row, square in repeats.weighed(results.rows([*_FIXED, *factors, *measures])):
        squares.append(square)
        repeated.append(repeats.repeats(cell_of(row)))
        for name in ("number", "scenario", "replication", "seed"):
            whole[name].append(row[name])
        whole["treatment"].append(treatments[row["treatment"]])
        whole["ending"].append(endings.setdefault(row["ending"], len(endings)))
        values["success"].append(row["success"])
        for name in factors:
            codes[name].append(levels[name].setdefault(row[name], len(levels[name])))
        for name in measures:
            value = row[name]
            known = isinstance(value, (int, float)) and abs(value) <= _MOST
            values[name].append(value if known else float("nan"))
            texts[name] += isinstance(value, str)
        if not row["success"]:
            failures.note(row)
    np = arrays()

    def column(given: array[Any], kind: Any) -> Any:
        return np.frombuffer(given, kind) if given else np.empty(0, kind)

    found = {name: column(each, np.int64) for name, each in whole.items()}
    numbers = {name: column(each, float) for name, each in values.items()}
    return Columns(
        treatments=tuple(treatments),
        endings=tuple(endings),
        numbers=found["number"],
        scenario=found["scenario"],
        treatment=found["treatment"],
        replication=found["replication"],
        seed=found["seed"],
        ending=found["ending"],
        success=numbers["success"],
        factors={name: column(each, np.int64) for name, each in codes.items()},
        levels={name: [*each] for name, each in levels.items()},
        measures={name: numbers[name] for name in measures},
        squares=column(squares, float),
        repeated=column(repeated, np.bool_),
        texts=+texts,
        failures=failures.all(),
    )


class _Failing:
    """Collects the runs without success."""

    def __init__(self, factors: Sequence[str]) -> None:
        self._factors = factors
        self._runs: list[Failure] = []
        self._causes: Counter[tuple[str, str]] = Counter()
        self._first: dict[tuple[str, str], int] = {}

    def note(self, row: Mapping[str, Any]) -> None:
        cause = row["ending"], row["cause"][:_MAX_CAUSE]
        self._causes[cause] += 1
        self._first.setdefault(cause, row["number"])
        if len(self._runs) < MAX_LISTED:
            values = {name: row[name] for name in Failure.model_fields if name != "levels"}
            self._runs.append(Failure(**values, levels={name: row[name] for name in self._factors}))

    def all(self) -> Failures:
        causes = tuple(
            Cause(ending=ending, cause=cause, runs=count, first=self._first[ending, cause])
            for (ending, cause), count in self._causes.most_common(_MAX_CAUSES)
        )
        return Failures(total=self._causes.total(), causes=causes, runs=tuple(self._runs))


def with_success(columns: Columns) -> Mapping[str, Numbers]:
    """Return the values of success and of all measures, by name."""
    return {"success": columns.success, **columns.measures}
