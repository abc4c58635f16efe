"""Repeated runs: replications without any randomness are the same run, and count once."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import replace
from statistics import fmean
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from hmrsim.experiments.statistics.verdicts import Criterion

COLUMNS: Final = ("scenario", "treatment", "fingerprint")
"""The columns of results that identify repeated runs."""

Cell = tuple[int, str]
"""A scenario and a treatment, which have one run per replication."""


class Repeats:
    """Finds the runs that repeat others.

    The replications of a scenario and a treatment are the same run if the simulator drew no random number in any of
    them, and all have the same result. If one differs, something else is random, such as the controller; then each
    counts, even if its result is equal to another.
    """

    def __init__(self) -> None:
        self._fingerprints: dict[Cell, str] = {}
        self._counts: Counter[Cell] = Counter()

    @classmethod
    def of(cls, rows: Iterable[Mapping[str, Any]]) -> Repeats:
        """Return the repeats among runs, of which at least the `COLUMNS` are given."""
        repeats = cls()
        for row in rows:
            repeats.note(cell_of(row), row["fingerprint"])
        return repeats

    def note(self, cell: Cell, fingerprint: str) -> None:
        """Add a run; a run without a fingerprint repeats no other."""
        self._counts[cell] += 1
        if self._fingerprints.setdefault(cell, fingerprint) != fingerprint:
            self._fingerprints[cell] = ""

    def repeats(self, cell: Cell) -> bool:
        """Return whether a scenario and a treatment have several runs, which are all the same."""
        return self._counts[cell] > 1 and bool(self._fingerprints[cell])

    def weighed(self, rows: Iterable[Mapping[str, Any]]) -> Iterator[tuple[Mapping[str, Any], int]]:
        """Yield each run with its contribution to the squared weights; see `counted`."""
        seen: Counter[Cell] = Counter()
        for row in rows:
            cell = cell_of(row)
            # (m + 1)² - m²: the runs of a cell that are the same are one of weight m.
            yield row, 2 * seen[cell] + 1
            seen[cell] += self.repeats(cell)


def counted(n: float, squares: float) -> int:
    """Return the effective number of runs, some of which repeat others.

    If all are different, or all are repeated equally often, it is the number of different runs. If only some are
    repeated, those have more weight, since every scenario counts in a statement about a treatment: n² / Σw² runs
    without weights have the same variance.

    *n* is the number of runs, and *squares* the sum of the squared weights; see `Repeats.weighed`.

    Source: Kish, Survey Sampling (1965), section 11.7.
    """
    return math.floor(n * n / squares + 1e-9) if squares else 0


def pairs_that_count(cells: Sequence[tuple[int, int]], repeated: Sequence[bool]) -> list[list[int]]:
    """Return the groups of pairs, by index, that count as one value each, which is the mean of the group.

    If no pair is repeated, each is a value; if all are, the first pair of each scenario is. If only some are, each
    replication of all scenarios is one value, since otherwise scenarios with more randomness would have more weight. A
    repeated pair belongs to all replications.

    *cells* has the scenario and the replication of each pair, and *repeated* whether both runs of it are the same in
    all replications.
    """
    if not any(repeated):
        return [[place] for place in range(len(cells))]
    fixed: dict[int, int] = {}
    varied: dict[int, list[int]] = {}
    for place, (scenario, replication) in enumerate(cells):
        if repeated[place]:
            fixed.setdefault(scenario, place)
        else:
            varied.setdefault(replication, []).append(place)
    if not varied:
        return [[place] for place in fixed.values()]
    scenarios = len({scenario for (scenario, _), again in zip(cells, repeated, strict=True) if not again})
    return [[*fixed.values(), *places] for places in varied.values() if len(places) == scenarios]


def means_of_pairs(
    one: Sequence[Any], two: Sequence[Any], groups: Iterable[Sequence[int]]
) -> tuple[list[float], list[float]]:
    """Return the mean values of each group of pairs, as of `pairs_that_count`, except groups in which one is missing.

    *one* and *two* have the value of the first and of the second run of each pair.
    """
    values = [([one[i] for i in group], [two[i] for i in group]) for group in groups]
    known = [(fmean(a), fmean(b)) for a, b in values if all(isinstance(each, (int, float)) for each in (*a, *b))]
    return [a for a, _ in known], [b for _, b in known]


def about_means(criterion: Criterion, groups: Iterable[Sized]) -> Criterion:
    """Return the criterion for groups of pairs: means of several values are not yes or no, even if all are 0 or 1."""
    return replace(criterion, yes_no=False) if any(len(group) > 1 for group in groups) else criterion


def cell_of(row: Mapping[str, Any]) -> Cell:
    """Return the cell of a run, of which at least the `COLUMNS` are given."""
    return row["scenario"], row["treatment"]


def note_of(runs: int, count: int) -> str:
    """Return a remark that runs count as fewer since some repeat others; "" if none does."""
    if count == runs:
        return ""
    return f"{runs:,} runs count as {count:,}, as the others repeat them: nothing was left to chance in these"


def note_of_pairs(pairs: int, repeated: Sequence[bool], values: int) -> Iterator[str]:
    """Yield a remark if the pairs count as fewer values."""
    if values == pairs:
        return
    if all(repeated):
        yield f"{pairs:,} pairs count as {values:,}, as the others repeat them: nothing was left to chance in these"
    else:
        yield (
            f"{pairs:,} pairs count as {values:,}, as nothing was left to chance in {sum(repeated):,} of them: one "
            "value for each replication, the mean over all scenarios"
        )


_HEADER: Final = '"kind":"header"'
"""The text that identifies the lines of a trace with the seed."""
_GOAL_ID: Final = re.compile(r"\b[0-9a-f]{32}\b")
"""The ids of goals, which differ between replications only because of the seed."""


def fingerprint_of(trace: str, *result: object) -> str:
    """Return a text that is equal for two runs if their traces and results differ only in the seed and goal ids.

    It differs if a controller draws random numbers itself. Runs in which the simulator drew random numbers may be equal
    by chance, so they need no fingerprint. *result* has JSON values.
    """
    ids: dict[str, str] = {}

    def numbered(match: re.Match[str]) -> str:
        return ids.setdefault(match[0], f"goal {len(ids)}")

    digest = hashlib.blake2b(digest_size=16)
    events = "\n".join(line for line in trace.splitlines() if _HEADER not in line)
    digest.update(_GOAL_ID.sub(numbered, events).encode())
    digest.update(json.dumps(result, sort_keys=True, default=str).encode())
    return digest.hexdigest()
