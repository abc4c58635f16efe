"""Each treatment compared with the first one, in pairs of the same scenario and replication."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

from hmrsim.experiments.contrast import SUCCESS, criterion_of, note_of_failed, withdrawal
from hmrsim.experiments.report.columns import MAX_LISTED
from hmrsim.experiments.report.model import Change, Comparison, Pair, Verdict, estimate_of
from hmrsim.experiments.results.repeats import about_means, note_of_pairs, pairs_that_count
from hmrsim.experiments.statistics.summaries import arrays
from hmrsim.experiments.statistics.verdicts import compare

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
