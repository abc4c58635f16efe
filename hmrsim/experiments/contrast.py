"""The comparison of two treatments, of one experiment or two, in pairs with the same seeds."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from hmrsim.diagnostics import instead, listed
from hmrsim.errors import ResultsError
from hmrsim.experiments.repeats import (
    COLUMNS,
    Repeats,
    about_means,
    cell_of,
    means_of_pairs,
    note_of_pairs,
    pairs_that_count,
)
from hmrsim.experiments.statistics.verdicts import Criterion, compare_all
from hmrsim.experiments.store import Results

if TYPE_CHECKING:
    from hmrsim.experiments.statistics.verdicts import Comparison

SUCCESS: Final = "success"
"""The measure of every experiment: whether a run ended as a success."""


@dataclass(frozen=True)
class Side:
    """A treatment of an experiment."""

    folder: Path
    treatment: str

    def __str__(self) -> str:
        """Return ``DIR:TREATMENT``, as on the command line."""
        return f"{self.folder}:{self.treatment}"


@dataclass(frozen=True)
class Contrast:
    """The comparison of treatment B with treatment A.

    Attributes:
        pairs: The number of seeds that both have.
        alone: The number of runs of A and of B without a counterpart.
        endings: The pairs that ended differently: the numbers of both runs and their endings.
        notes: Reasons to doubt the comparison.
    """

    a: Side
    b: Side
    pairs: int
    alone: tuple[int, int]
    comparisons: Mapping[str, Comparison]
    endings: tuple[tuple[int, int, str, str], ...]
    notes: tuple[str, ...]


def sides_of(a: str, b: str) -> tuple[Side, Side]:
    """Return the sides that two texts name, each ``DIR`` or ``DIR:TREATMENT``.

    Raises:
        ResultsError: There are no such results, or a treatment has to be named.
    """
    return _side(a, 0 if a == b else None), _side(b, 1 if a == b else None)


def _side(text: str, number: int | None) -> Side:
    folder, colon, treatment = text.rpartition(":")
    if not colon or Path(text).is_dir():
        folder, treatment = text, ""
    with Results(Path(folder)) as results:
        names: list[str] = results.about["treatments"]
    if treatment and treatment not in names:
        raise ResultsError(f"{folder}: there is no treatment {treatment!r}{instead(treatment, names)}")
    if not treatment:
        if number is not None and len(names) == 2:  # noqa: PLR2004 - the two of one experiment
            treatment = names[number]
        elif len(names) == 1:
            treatment = names[0]
        else:
            raise ResultsError(f"{folder}: has the treatments {listed(names)}; name one: {folder}:{names[0]}")
    return Side(Path(folder), treatment)


def contrast(
    a: Side, b: Side, *, measures: Collection[str] = (), margins: Mapping[str, float] | None = None, alpha: float = 0.05
) -> Contrast:
    """Compare treatment B with treatment A, by default in success and all measures that both have.

    *margins* replace those in the file, and *alpha* is the probability that any verdict is false.

    Raises:
        ResultsError: One of them has no runs, they have no seed in common, or there is no such measure.
    """
    with ExitStack() as stack:
        first, second = (stack.enter_context(Results(side.folder)) for side in (a, b))
        common = [SUCCESS, *(name for name in first.about["measures"] if name in second.about["measures"])]
        for name in [*measures, *(margins or {})]:
            if name not in common:
                raise ResultsError(f"there is no measure {name!r}{instead(name, common, verb='both have')}")
        wanted = [*dict.fromkeys(measures or common)]
        columns = [*COLUMNS, *dict.fromkeys(["number", "replication", "seed", "ending", SUCCESS, *wanted])]
        runs_a = {row["seed"]: row for row in first.rows(columns, {"treatment": a.treatment})}
        runs_b = {row["seed"]: row for row in second.rows(columns, {"treatment": b.treatment})}
        for side, runs in ((a, runs_a), (b, runs_b)):
            if not runs:
                raise ResultsError(f"{side} has no runs yet; `hmrsim experiment run FILE -o {side.folder}` makes them")
        # By replication, and in pseudo-random order within each, not level by level as in the design.
        seeds = sorted(runs_a.keys() & runs_b.keys(), key=lambda seed: (runs_a[seed]["replication"], seed))
        if not seeds:
            raise ResultsError(
                f"{a} and {b} have no seed in common, so that they can't be compared in pairs; seeds depend on the "
                "name, the seed and the factors of an experiment"
            )
        same_a, same_b = Repeats.of(runs_a.values()), Repeats.of(runs_b.values())
        repeated = [same_a.repeats(cell_of(runs_a[seed])) and same_b.repeats(cell_of(runs_b[seed])) for seed in seeds]
        cells = [(runs_a[seed]["scenario"], runs_a[seed]["replication"]) for seed in seeds]
        places = pairs_that_count(cells, repeated)
        about = {name: criterion_of(name, first.about["measures"], margins or {}) for name in wanted}
        criteria = {name: about_means(each, places) for name, each in about.items()}
        notes = [*_notes(first.about, second.about), *note_of_pairs(len(seeds), repeated, len(places))]
    values: dict[str, tuple[list[float], list[float]]] = {}
    for name in wanted:
        one, two = ([runs[seed][name] for seed in seeds] for runs in (runs_a, runs_b))
        values[name] = means_of_pairs(one, two, places)
        if missing := len(places) - len(values[name][0]):
            notes.append(f"{name}: {missing} of {len(places)} pairs have no value")
        notes += note_of_failed(name, sum(_failed(runs_a[seed], runs_b[seed], name) for seed in seeds), len(seeds))
    try:
        comparisons = compare_all(values, criteria, alpha=alpha)
    except ValueError as error:
        raise ResultsError(f"{a} and {b} can't be compared: {error}") from None
    notes += [f"{name}: {withdrawal(each)}" for name, each in comparisons.items() if each.withdrawn]
    return Contrast(
        a,
        b,
        len(seeds),
        (len(runs_a) - len(seeds), len(runs_b) - len(seeds)),
        comparisons,
        tuple(
            (one["number"], two["number"], one["ending"], two["ending"])
            for one, two in ((runs_a[seed], runs_b[seed]) for seed in seeds)
            if one["ending"] != two["ending"]
        ),
        tuple(notes),
    )


def withdrawal(comparison: Comparison) -> str:
    """Return the verdicts that were withdrawn, and the reason, as part of a sentence."""
    verdicts = " and ".join(map(repr, comparison.withdrawn))
    return f"{verdicts} withdrawn, since all pairs together contradict what the first ones said"


def criterion_of(name: str, measures: Mapping[str, Any], margins: Mapping[str, float] | None = None) -> Criterion:
    """Return the criterion for success, or for one of the measures in an experiment's results.

    *margins* replace those in the file; 0 is for none.
    """
    given = margins or {}
    if name == SUCCESS:
        return Criterion(larger_is_better=True, margin=given.get(name) or None, yes_no=True)
    said = measures[name]
    margin = given.get(name, said["margin"]) or None
    return Criterion(said["better"] == "larger", margin, relative=said["relative"] and name not in given)


def note_of_failed(name: str, failed: int, pairs: int) -> Iterator[str]:
    """Yield a remark if pairs have values of runs without success."""
    if failed and name != SUCCESS:
        yield f"{name}: {failed:,} of {pairs:,} pairs have a run without success"


def _failed(one: Mapping[str, Any], two: Mapping[str, Any], name: str) -> bool:
    return _is_number(one[name]) and _is_number(two[name]) and not (one[SUCCESS] and two[SUCCESS])


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float))


def _notes(one: Mapping[str, Any], two: Mapping[str, Any]) -> Iterator[str]:
    """Yield the differences between the experiments apart from their treatments."""
    for key, what in (("world", "the world"), ("variant", "the variants"), ("hmrsim", "the version of hmrsim")):
        if one[key] != two[key]:
            yield f"{what} is not the same for both"
