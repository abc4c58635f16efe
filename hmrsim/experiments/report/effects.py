"""The effects of factors on each measure, and their interactions. The treatment counts as a factor.

The values are those of `hmrsim.experiments.statistics.main_effects` and `interactions`, but computed from counts and
sums by level, which is a hundred times faster.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.experiments.contrast import SUCCESS
from hmrsim.experiments.report.columns import with_success
from hmrsim.experiments.report.model import Effects, Estimate, Interaction, Level, estimate_of
from hmrsim.experiments.results.repeats import counted
from hmrsim.experiments.results.table import share_of
from hmrsim.experiments.statistics.intervals import CONFIDENCE
from hmrsim.experiments.statistics.summaries import arrays, distributions

if TYPE_CHECKING:
    from hmrsim.experiments.report.columns import Codes, Columns, Numbers

TREATMENT: Final = "treatment"
"""The name of the treatment among the factors."""

MAX_INTERACTIONS: Final = 5
"""The maximum number of pairs of factors whose interactions are reported."""

_MAX_LEVELS: Final = 12
"""The levels of a numeric factor with more levels are put into bands."""
_BANDS: Final = 5
_MAX_TEXTS: Final = 50
_BALANCE: Final = 0.1
"""The share by which the number of runs at two levels may differ from that of independent factors."""
_MAX_PAIRS: Final = 5
"""The maximum number of pairs of factors in a note."""
_NOTHING: Final = 1e-9
"""Effects below this share of the spread of the values come from rounding."""


class _Factor(NamedTuple):
    """A factor: the names of its levels, and the index of its level for each run."""

    name: str
    levels: Sequence[str]
    codes: Codes


def effects_of(columns: Columns) -> dict[str, Effects]:
    """Return the effects on each measure that has values; nothing if no factor has two levels."""
    notes: list[str] = []
    factors = [*_factors(columns, notes)]
    if not factors:
        return {}
    if len({*columns.treatment.tolist()}) > 1:
        factors.append(_Factor(TREATMENT, columns.treatments, columns.treatment))
    together = [*_together(factors, notes)]
    found = {}
    for name, values in with_success(columns).items():
        known = ~arrays().isnan(values)
        if known.any():
            chosen = [_Factor(each.name, each.levels, each.codes[known]) for each in factors]
            weights = columns.squares[known]
            found[name] = _effects(values[known], weights, chosen, together, notes, shares=name == SUCCESS)
    return found


def _factors(columns: Columns, notes: list[str]) -> Iterator[_Factor]:
    for name, codes in columns.factors.items():
        levels = columns.levels[name]
        numeric = all(isinstance(level, (int, float)) for level in levels)
        if len(levels) > _MAX_LEVELS and numeric:
            notes.append(f"{name} has {len(levels):,} levels, which are put into {_BANDS} bands")
            yield _banded(name, levels, codes)
        elif len(levels) > _MAX_TEXTS:
            notes.append(f"{name} has {len(levels):,} levels, too many to be shown")
        elif len(levels) > 1:
            order = sorted(range(len(levels)), key=levels.__getitem__) if numeric else range(len(levels))
            places = arrays().argsort(arrays().asarray([*order]))
            yield _Factor(name, [str(levels[each]) for each in order], places[codes])


def _banded(name: str, levels: Sequence[float], codes: Codes) -> _Factor:
    """Return a factor whose levels are bands of equally many levels."""
    np = arrays()
    ordered = sorted(levels)
    parts = [each.tolist() for each in np.array_split(np.asarray(ordered, float), _BANDS)]
    band = np.searchsorted([part[-1] for part in parts], np.asarray(levels, float))
    return _Factor(name, [f"{part[0]:.4g} to {part[-1]:.4g}" for part in parts], band[codes])


def _together(factors: Sequence[_Factor], notes: list[str]) -> Iterator[tuple[int, int]]:
    """Yield the pairs of factors whose levels all occur together; note the others, and those that occur unevenly."""
    missing, uneven = [], []
    for one, other in itertools.combinations(range(len(factors)), 2):
        counts = _counts(factors[one], factors[other])
        expected = counts.sum(1)[:, None] * counts.sum(0)[None, :] / counts.sum()
        both = f"{factors[one].name} and {factors[other].name}"
        if not counts.all():
            missing.append(both)
            continue
        if (abs(counts - expected) > _BALANCE * expected).any():
            uneven.append(both)
        yield one, other
    if missing:
        notes.append(f"not all levels occur together, so that interactions are not known: {_some(missing)}")
    if uneven:
        notes.append(
            "levels do not occur together equally often, so that the effect of one contains some of the other's: "
            f"{_some(uneven)}"
        )


def _some(pairs: Sequence[str]) -> str:
    more = f" and {len(pairs) - _MAX_PAIRS} more pairs" if len(pairs) > _MAX_PAIRS else ""
    return ", ".join(pairs[:_MAX_PAIRS]) + more


def _counts(one: _Factor, other: _Factor) -> Any:
    size = len(one.levels), len(other.levels)
    both = one.codes * size[1] + other.codes
    return arrays().bincount(both, minlength=size[0] * size[1]).reshape(size)


class _Cells(NamedTuple):
    """Count, mean, sum of squared distances from the mean, and effective number of runs, by level."""

    counts: Codes
    means: Numbers
    squares: Numbers
    numbers: Sequence[int]

    def mean(self, cell: int, *, shares: bool) -> Estimate:
        """Return the mean at a level with Student's interval, or the share with Wilson's."""
        runs, n, mean = int(self.counts[cell]), self.numbers[cell], float(self.means[cell])
        if shares:
            return estimate_of(share_of(round(mean * runs), runs, n))
        if n < 2:  # noqa: PLR2004 - one value has no spread
            return Estimate(estimate=mean, low=None, high=None, n=n)
        error = math.sqrt(float(self.squares[cell]) / runs / (n - 1))
        half = float(distributions().t.isf((1 - CONFIDENCE) / 2, n - 1)) * error
        return Estimate(estimate=mean, low=mean - half, high=mean + half, n=n)


def _cells(codes: Codes, size: int, values: Numbers, weights: Numbers) -> _Cells:
    np = arrays()
    counts = np.bincount(codes, minlength=size)
    means = np.bincount(codes, values, size) / np.maximum(counts, 1)
    numbers = map(counted, counts.tolist(), np.bincount(codes, weights, size).tolist())
    return _Cells(counts, means, np.bincount(codes, (values - means[codes]) ** 2, size), [*numbers])


def _effects(
    values: Numbers,
    weights: Numbers,
    factors: Sequence[_Factor],
    together: Sequence[tuple[int, int]],
    notes: list[str],
    *,
    shares: bool,
) -> Effects:
    mean = math.fsum(values.tolist()) / len(values)
    alone = [_cells(each.codes, len(each.levels), values, weights) for each in factors]
    levels = [
        Level(factor=factor.name, level=level, mean=cells.mean(place, shares=shares), effect=cells.means[place] - mean)
        for factor, cells in zip(factors, alone, strict=True)
        for place, level in enumerate(factor.levels)
        if cells.counts[place]
    ]
    least = _NOTHING * float(abs(values - mean).max())
    found: list[tuple[float, Interaction]] = []
    for one, other in together:
        first, second = factors[one], factors[other]
        width = len(second.levels)
        cells = _cells(first.codes * width + second.codes, len(first.levels) * width, values, weights)
        expected = (alone[one].means[:, None] + alone[other].means[None, :] - mean).ravel()
        beyond = arrays().where(cells.counts > 0, abs(cells.means - expected), 0.0)
        cell = int(beyond.argmax())
        if beyond[cell] > least:
            interaction = Interaction(
                factors=(first.name, second.name),
                levels=(first.levels[cell // width], second.levels[cell % width]),
                mean=cells.mean(cell, shares=shares),
                expected=float(expected[cell]),
            )
            found.append((float(beyond[cell]), interaction))
    found.sort(key=lambda each: -each[0])
    largest = tuple(interaction for _, interaction in found[:MAX_INTERACTIONS])
    return Effects(mean=mean, levels=tuple(levels), interactions=largest, notes=tuple(notes))
