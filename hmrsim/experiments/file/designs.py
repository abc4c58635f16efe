"""Designs: from factors to the combinations of levels that are run."""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from itertools import product
from typing import Any

from hmrsim.diagnostics import instead
from hmrsim.experiments.file.model import Design, ExperimentFile, Range
from hmrsim.world.overlays.tables import as_rows

Levels = dict[str, Any]
"""A level for each factor."""

MAX_SCENARIOS = 1_000_000
"""Maximum number of scenarios of an experiment."""


class DesignFlaw(ValueError):
    """A design can't be made; the text says why.

    Attributes:
        key: The key of the file that is wrong.
    """

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


def scenarios_of(file: ExperimentFile, trials: Any = None) -> list[Levels]:
    """Return the levels of each scenario, in order.

    Args:
        file: The experiment.
        trials: The table that its design names, if it names one.

    Raises:
        DesignFlaw: They can't be made.
    """
    design = file.design
    if isinstance(design, Design) and design.list is not None:
        return _listed(file.factors, design.list if trials is None else trials)
    if isinstance(design, Design) and design.latin_hypercube is not None:
        return _latin_hypercube(file.factors, design.latin_hypercube, f"{file.name}/{file.seed}")
    discrete: dict[str, Sequence[Any]] = {}
    for name, levels in file.factors.items():
        if isinstance(levels, Range):
            raise DesignFlaw("design", f"{name} is a range, which only a latin_hypercube draws from; list its levels")
        if not levels:
            raise DesignFlaw("factors", f"{name} has no levels")
        discrete[name] = levels
    return _full(discrete) if design == "full" else _one_at_a_time(discrete)


def _full(factors: Mapping[str, Sequence[Any]]) -> list[Levels]:
    """Return all combinations; the last factor varies first."""
    count = math.prod(len(levels) for levels in factors.values())
    if count > MAX_SCENARIOS:
        raise DesignFlaw("design", f"{count} combinations are more than {MAX_SCENARIOS}; a latin_hypercube needs fewer")
    return [dict(zip(factors, levels, strict=True)) for levels in product(*factors.values())]


def _one_at_a_time(factors: Mapping[str, Sequence[Any]]) -> list[Levels]:
    """Return the first levels of all factors, and each other level with the first ones of the others."""
    base = {name: levels[0] for name, levels in factors.items()}
    return [base, *({**base, name: level} for name, levels in factors.items() for level in levels[1:])]


def _latin_hypercube(factors: Mapping[str, Sequence[Any] | Range], count: int, seed: str) -> list[Levels]:
    """Return so many scenarios; of each factor each of so many equal parts of its range, or levels, occurs once.

    McKay, Beckman, Conover, A Comparison of Three Methods for Selecting Values of Input Variables in the Analysis of
    Output from a Computer Code, Technometrics 21 (1979).
    """
    columns = {}
    for name, levels in factors.items():
        # Not for cryptography: the scenarios are the same for each one who runs the file.
        chance = random.Random(f"{seed}/{name}")
        parts = [*range(count)]
        chance.shuffle(parts)
        columns[name] = [_level(levels, (part + chance.random()) / count) for part in parts]
    return [dict(zip(columns, levels, strict=True)) for levels in zip(*columns.values(), strict=True)]


def _level(levels: Sequence[Any] | Range, share: float) -> Any:
    if not isinstance(levels, Range):
        return levels[int(share * len(levels))]
    if levels.whole:
        low, high = math.ceil(levels.low), math.floor(levels.high)
        return low + int(share * (high - low + 1))
    return levels.low + share * (levels.high - levels.low)


def _listed(factors: Mapping[str, Sequence[Any] | Range], trials: Any) -> list[Levels]:
    rows = as_rows(trials)
    if not rows:
        raise DesignFlaw("design", "expected a table with a row for each scenario and a column for each factor")
    known = [*factors] if factors else [*rows[0]]
    for i, row in enumerate(rows):
        missing = [name for name in known if name not in row]
        if missing:
            raise DesignFlaw("design", f"row {i + 1} has no {missing[0]!r}{instead(missing[0], row, verb='it has')}")
    return [{name: row[name] for name in known} for row in rows]
