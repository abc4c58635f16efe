"""Runs that are the same run: replications of what leaves nothing to chance count once."""

from __future__ import annotations

import hashlib
import json
import math
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence, Sized
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from hmrsim.experiments.statistics.verdicts import Criterion

COLUMNS: Final = ("scenario", "treatment", "fingerprint")
"""The columns of results that say which runs are the same."""

Cell = tuple[int, str]
"""A scenario and a treatment: what is run once for each replication."""


class Repeats:
    """Knows which runs repeat others.

    The replications of a scenario and a treatment are the same run if the simulator has drawn a random number in none
    of them, and all came out the same. One that differs shows that something else leaves them to chance, such as the
    controller; then each counts, also those that are alike.
    """

    def __init__(self) -> None:
        self._fingerprints: dict[Cell, str] = {}
        self._counts: Counter[Cell] = Counter()

    @classmethod
    def of(cls, rows: Iterable[Mapping[str, Any]]) -> Repeats:
        """Return those among some runs, by their `COLUMNS`."""
        repeats = cls()
        for row in rows:
            repeats.note(cell_of(row), row["fingerprint"])
        return repeats

    def note(self, cell: Cell, fingerprint: str) -> None:
        """Note a run; without a fingerprint it repeats none."""
        self._counts[cell] += 1
        if self._fingerprints.setdefault(cell, fingerprint) != fingerprint:
            self._fingerprints[cell] = ""

    def repeats(self, cell: Cell) -> bool:
        """Return whether there are several runs of a scenario and a treatment, and all are the same."""
        return self._counts[cell] > 1 and bool(self._fingerprints[cell])

    def weighed(self, rows: Iterable[Mapping[str, Any]]) -> Iterator[tuple[Mapping[str, Any], int]]:
        """Yield each of some runs with what it adds to the squares of the weights; see `counted`."""
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

    Source: Kish, Survey Sampling (1965), section 11.7.

    Args:
        n: How many there are.
        squares: The sum of what each of them adds; see `Repeats.weighed`.
    """
    return math.floor(n * n / squares + 1e-9) if squares else 0


def pairs_that_count(cells: Sequence[tuple[int, int]], repeated: Sequence[bool]) -> list[list[int]]:
    """Return which pairs of two treatments are one value together, by their places: the mean of theirs.

    If none is repeated, each is a value, and if all are, the first one of each scenario is. If only some are, the
    others can't stand alone, as the scenarios that leave more to chance would have more weight than the others: each
    replication of all scenarios is one value. A pair that is repeated belongs to all replications.

    Args:
        cells: The scenario and the replication of each pair, in the order in which they are read.
        repeated: Whether both runs of the pair are the same in all replications.
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


def about_means(criterion: Criterion, groups: Iterable[Sized]) -> Criterion:
    """Return what is asked about the values of some groups of pairs: means of several are no yes or no.

    Also if all of them are 0 or 1, for the time being.
    """
    return replace(criterion, yes_no=False) if any(len(group) > 1 for group in groups) else criterion


def cell_of(row: Mapping[str, Any]) -> Cell:
    """Return the cell of a run, of which at least the `COLUMNS` are given."""
    return row["scenario"], row["treatment"]


def note_of(runs: int, count: int) -> str:
    """Return in words that some runs count as fewer; "" if none repeats another."""
    if count == runs:
        return ""
    return f"{runs:,} runs count as {count:,}, as the others repeat them: nothing was left to chance in these"


def note_of_pairs(pairs: int, repeated: Sequence[bool], values: int) -> Iterator[str]:
    """Yield in words how many of some pairs are compared, if they are not all."""
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
"""What the lines of a trace have that say the seed."""
_GOAL_ID: Final = re.compile(r"\b[0-9a-f]{32}\b")
"""Ids of goals depend on the seed, and on nothing else that differs between replications."""


def fingerprint_of(trace: str, *result: object) -> str:
    """Return a text that is the same for two runs if they differ in nothing but the seed and the ids of goals.

    It says whether a controller draws random numbers itself: then its runs differ. Whether the simulator has drawn
    any has to be known besides, as runs may be equal by chance.

    Args:
        trace: The trace of the run.
        result: The result of the run, in JSON values.
    """
    ids: dict[str, str] = {}

    def numbered(match: re.Match[str]) -> str:
        return ids.setdefault(match[0], f"goal {len(ids)}")

    digest = hashlib.blake2b(digest_size=16)
    events = "\n".join(line for line in trace.splitlines() if _HEADER not in line)
    digest.update(_GOAL_ID.sub(numbered, events).encode())
    digest.update(json.dumps(result, sort_keys=True, default=str).encode())
    return digest.hexdigest()
