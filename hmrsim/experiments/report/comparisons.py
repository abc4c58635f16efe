"""Comparisons of the treatments with the first one, and the effects of factors on each measure.

The values are those of `hmrsim.experiments.statistics.main_effects` and `interactions`, but computed from counts and
sums by level, which is a hundred times faster.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.experiments.contrast import SUCCESS, criterion_of, note_of_failed, withdrawal
from hmrsim.experiments.repeats import about_means, counted, note_of_pairs, pairs_that_count
from hmrsim.experiments.report.columns import MAX_LISTED, with_success
from hmrsim.experiments.report.model import (
    Change,
    Comparison,
    Effects,
    Estimate,
    Interaction,
    Level,
    Pair,
    Verdict,
    estimate_of,
)
from hmrsim.experiments.statistics.intervals import CONFIDENCE
from hmrsim.experiments.statistics.summaries import arrays, distributions
from hmrsim.experiments.statistics.verdicts import compare
from hmrsim.experiments.table import share_of

if TYPE_CHECKING:
    from hmrsim.experiments.report.columns import Codes, Columns, Flags, Numbers
    from hmrsim.experiments.statistics.verdicts import Comparison as Compared
    from hmrsim.experiments.statistics.verdicts import Criterion


ALPHA: Final = 0.05
"""The probability that any verdict is false."""

MAX_PAIRS: Final = 50_000
"""The number of pairs that are compared: a verdict on more takes seconds, and is hardly ever different."""

_MAX_CHANGES: Final = 20


class _Paired(NamedTuple):
    """The pairs of runs of the first treatment and another one, in order.

    Attributes:
        first: The indices of the runs of the first treatment.
        other: The indices of the runs of the other treatment.
        alone: The number of runs of either without a counterpart.
        cells: The scenario and the replication of each pair.
        repeated: Whether its two runs are the same in all replications.
    """

    first: Codes
    other: Codes
    alone: tuple[int, int]
    cells: Sequence[tuple[int, int]]
    repeated: Flags


def comparisons_of(columns: Columns, about: Mapping[str, Any]) -> tuple[Comparison, ...]:
    """Return the comparisons of all treatments with the first one.

    All verdicts together are true with probability 1 - `ALPHA`. If the experiment ran until a measure was decided, the
    verdicts on this measure use the confidence in its file, so that they are the same as when it stopped.
    """
    return tuple(_comparison(columns, about, other) for other in range(1, len(columns.treatments)))


def _comparison(columns: Columns, about: Mapping[str, Any], other: int) -> Comparison:
    paired = _paired(columns, other)
    np = arrays()
    share = 1 / (len(columns.treatments) - 1)
    alphas = _alphas(about)
    verdicts: dict[str, Verdict] = {}
    groups = [*map(np.asarray, pairs_that_count(paired.cells, paired.repeated.tolist()))]
    notes = [*note_of_pairs(len(paired.first), paired.repeated.tolist(), len(groups))]
    for name, values in {SUCCESS: columns.success, **columns.measures}.items():
        one, two = _values(values[paired.first], groups), _values(values[paired.other], groups)
        known = ~arrays().isnan(one + two)
        criterion = about_means(criterion_of(name, about["measures"]), groups)
        criterion = replace(criterion, alpha=alphas[name] * share)
        failed = columns.success[paired.first] * columns.success[paired.other] == 0
        failed &= ~np.isnan(values[paired.first] + values[paired.other])
        remarks = [*_notes(name, known, one, criterion), *note_of_failed(name, int(failed.sum()), len(failed))]
        if criterion.relative and (one[known] < 0).any():
            criterion = replace(criterion, margin=None, relative=False)
        found = compare(one[known][:MAX_PAIRS].tolist(), two[known][:MAX_PAIRS].tolist(), criterion)
        verdicts[name] = _verdict(found, criterion)
        notes += [*remarks, *([f"{name}: {withdrawal(found)}"] if found.withdrawn else [])]
    differing = columns.ending[paired.first] != columns.ending[paired.other]
    runs = zip(paired.first[differing][:MAX_LISTED], paired.other[differing][:MAX_LISTED], strict=True)
    return Comparison(
        first=columns.treatments[0],
        treatment=columns.treatments[other],
        pairs=len(paired.first),
        alone=paired.alone,
        measures=verdicts,
        changes=_changes(columns, paired.first[differing], paired.other[differing]),
        differing=int(differing.sum()),
        runs=tuple(_pair(columns, int(one), int(two)) for one, two in runs),
        notes=tuple(notes),
    )


def _alphas(about: Mapping[str, Any]) -> dict[str, float]:
    """Return the probability of a false verdict of each measure, for all treatments together."""
    names = [SUCCESS, *about["measures"]]
    until = about["replications"]["until"]
    if not until or not until.get("decided"):
        return dict.fromkeys(names, ALPHA / len(names))
    shared = dict.fromkeys(names, ALPHA / (len(names) - 1))
    return {**shared, until["measure"]: 1 - until["confidence"]}


def _paired(columns: Columns, other: int) -> _Paired:
    np = arrays()
    places = [np.flatnonzero(columns.treatment == each) for each in (0, other)]
    # The runs of a scenario and a replication have consecutive numbers.
    cells = [columns.numbers[each] // len(columns.treatments) for each in places]
    both, first, second = np.intersect1d(*cells, assume_unique=True, return_indices=True)
    alone = len(places[0]) - len(both), len(places[1]) - len(both)
    # In the order of `contrast`, and not level by level as in the design.
    order = np.lexsort((columns.seed[places[0][first]], columns.replication[places[0][first]]))
    one, two = places[0][first][order], places[1][second][order]
    cells = [*zip(columns.scenario[one].tolist(), columns.replication[one].tolist(), strict=True)]
    return _Paired(one, two, alone, cells, columns.repeated[one] & columns.repeated[two])


def _values(values: Numbers, groups: Sequence[Codes]) -> Numbers:
    """Return the mean of each group of values."""
    np = arrays()
    if all(len(group) == 1 for group in groups):
        alone: Numbers = values[np.asarray([int(group[0]) for group in groups], np.int64)]
        return alone
    means: Numbers = np.asarray([values[group].mean() for group in groups], float)
    return means


def _verdict(found: Compared, criterion: Criterion) -> Verdict:
    return Verdict(
        verdict=found.verdict,
        decided_after=found.decided_after,
        difference=estimate_of(found.difference),
        differing=found.differing,
        alpha=criterion.alpha,
        margin=criterion.margin,
        relative=criterion.relative,
    )


def _notes(name: str, known: Any, one: Numbers, criterion: Criterion) -> Iterator[str]:
    with_values = int(known.sum())
    if with_values < len(known):
        yield f"{name}: {len(known) - with_values:,} of {len(known):,} pairs have no value"
    if with_values > MAX_PAIRS:
        yield f"{name}: the first {MAX_PAIRS:,} of {with_values:,} pairs are compared"
    if criterion.relative and (one[known] < 0).any():
        yield f"{name}: has values below 0, of which no margin can be a share; compared without a margin"


def _changes(columns: Columns, first: Codes, other: Codes) -> tuple[Change, ...]:
    """Return the pairs of endings with their counts, the most frequent first."""
    endings = columns.endings
    codes = columns.ending[first] * len(endings) + columns.ending[other]
    found, counts = arrays().unique(codes, return_counts=True)
    ordered = sorted(zip(counts.tolist(), found.tolist(), strict=True), key=lambda each: (-each[0], each[1]))
    return tuple(
        Change(first=endings[code // len(endings)], other=endings[code % len(endings)], pairs=count)
        for count, code in ordered[:_MAX_CHANGES]
    )


def _pair(columns: Columns, one: int, two: int) -> Pair:
    return Pair(
        scenario=int(columns.scenario[one]),
        levels=columns.levels_of(one),
        replication=int(columns.replication[one]),
        seed=int(columns.seed[one]),
        first=int(columns.numbers[one]),
        first_ending=columns.endings[columns.ending[one]],
        other=int(columns.numbers[two]),
        other_ending=columns.endings[columns.ending[two]],
    )


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
        notes.append(f"not all levels occur together, so that interactions are not known: {_first_of(missing)}")
    if uneven:
        notes.append(
            "levels do not occur together equally often, so that the effect of one contains some of the other's: "
            f"{_first_of(uneven)}"
        )


def _first_of(pairs: Sequence[str]) -> str:
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
