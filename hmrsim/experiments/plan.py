"""The plan of an experiment: its scenarios, runs and seeds."""

from __future__ import annotations

import hashlib
import json
import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import product
from typing import TYPE_CHECKING, Any, Final

from hmrsim.caches import LruCache
from hmrsim.diagnostics import instead
from hmrsim.experiments.model import Design, ExperimentFile, Range
from hmrsim.world.overlays.overlay import Overlay
from hmrsim.world.overlays.tables import as_rows
from hmrsim.world_checks.loading import BaseWorld, base_world

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.experiments.model import Treatment
    from hmrsim.world.merging import Source
    from hmrsim.world_checks import LoadedWorld

_KEPT_WORLDS: Final = 256
"""The number of worlds that a process keeps."""


@dataclass(frozen=True)
class Run:
    """A run of an experiment; its scenario and its replication are numbers from 0.

    Attributes:
        number: Its number in the experiment, from 0.
        seed: The seed of its world; the same for all treatments.
    """

    number: int
    scenario: int
    treatment: str
    replication: int
    seed: int


@dataclass(frozen=True)
class Plan:
    """An experiment that can be run.

    Attributes:
        scenarios: The levels of each scenario.
        overlays: The overlays of the world, without values for the names of factors.
        source: The file of the world, or the name of a shipped one.
        variant: The names of the chosen variants.
        own_overlays: The overlays for single treatments, by the name of the treatment.
        left_to_chance: The scenarios and treatments whose runs drew random numbers, so far as this process made any.
    """

    path: Path
    file: ExperimentFile
    scenarios: Sequence[Levels]
    overlays: Sequence[Source]
    tables: Mapping[str, Any]
    source: str
    variant: tuple[str, ...] = ()
    own_overlays: Mapping[str, Source] = field(default_factory=dict)
    left_to_chance: set[tuple[int, str]] = field(default_factory=set, compare=False, repr=False)
    _worlds: LruCache[str, LoadedWorld] = field(
        default_factory=partial(LruCache, _KEPT_WORLDS), compare=False, repr=False
    )

    @property
    def treatments(self) -> dict[str, Treatment]:
        """The treatments of the experiment, by name."""
        return self.file.treatments

    @cached_property
    def hash(self) -> str:
        """SHA-256 of everything that decides the results: the file, its tables and the variants.

        Default values are left out, so that a version with further keys can continue results of earlier versions.
        """
        content: dict[str, Any] = {
            "file": self.file.model_dump(mode="json", exclude_defaults=True),
            "tables": self.tables,
            "variant": self.variant,
            "scenarios": list(self.scenarios),
        }
        return hashlib.sha256(json.dumps(content, sort_keys=True, default=str).encode()).hexdigest()

    def run(self, scenario: int, treatment: str, replication: int) -> Run:
        """Return a run; its number does not depend on the number of replications."""
        names = [*self.treatments]
        number = (replication * len(self.scenarios) + scenario) * len(names) + names.index(treatment)
        return Run(number, scenario, treatment, replication, self._seed(scenario, replication))

    def run_of(self, number: int) -> Run | None:
        """Return the run of a number; None if there is none."""
        names = [*self.treatments]
        cell, treatment = divmod(number, len(names))
        replication, scenario = divmod(cell, len(self.scenarios))
        if number < 0 or replication >= self.file.replications.max:
            return None
        return self.run(scenario, names[treatment], replication)

    def names(self, scenario: int) -> dict[str, Any]:
        """Return the names for expressions in a scenario: the tables, and a level for each factor."""
        return {**self.tables, **self.scenarios[scenario]}

    def world(self, scenario: int, treatment: str = "") -> LoadedWorld:
        """Return the world of a scenario, with the overlay of a treatment if given; each world is loaded once.

        Raises:
            WorldError: It is invalid.
        """
        own = [self.own_overlays[treatment]] if treatment in self.own_overlays else []
        key = json.dumps([self.scenarios[scenario], treatment if own else ""], sort_keys=True, default=str)

        def load() -> LoadedWorld:
            names = self.names(scenario)
            return self._base.load([Overlay(each, names) for each in (*self.overlays, *own)])

        return self._worlds.get(key, load)

    @cached_property
    def _base(self) -> BaseWorld:
        return base_world(self.source)

    def _seed(self, scenario: int, replication: int) -> int:
        """Return a seed that depends on the experiment, the scenario's levels and the replication alone."""
        levels = json.dumps(self.scenarios[scenario], sort_keys=True, default=str)
        text = f"{self.file.name}/{self.file.seed}/{levels}/{replication}".encode()
        return int.from_bytes(hashlib.blake2b(text, digest_size=8).digest()) >> 33


Levels = dict[str, Any]
"""A level for each factor."""

MAX_SCENARIOS = 1_000_000
"""Maximum number of scenarios of an experiment."""


class DesignFlaw(ValueError):
    """A design is invalid, for the reason in the text; *key* is the invalid key of the file."""

    def __init__(self, key: str, message: str) -> None:
        super().__init__(message)
        self.key = key


def scenarios_of(file: ExperimentFile, trials: Any = None) -> list[Levels]:
    """Return the levels of each scenario, in order; *trials* is the table that the design names, if it names one.

    Raises:
        DesignFlaw: The design is invalid.
    """
    design = file.design
    if isinstance(design, Design) and design.list is not None:
        return _listed(file.factors, design.list if trials is None else trials)
    for name, levels in file.factors.items():
        if not isinstance(levels, Range) and not levels:
            raise DesignFlaw("factors", f"{name} has no levels")
    if isinstance(design, Design) and design.latin_hypercube is not None:
        if not file.factors:
            raise DesignFlaw("design", "a latin_hypercube needs factors to draw; there are none")
        return _latin_hypercube(file.factors, design.latin_hypercube, f"{file.name}/{file.seed}")
    discrete: dict[str, Sequence[Any]] = {}
    for name, levels in file.factors.items():
        if isinstance(levels, Range):
            raise DesignFlaw("design", f"{name} is a range, which only a latin_hypercube draws from; list its levels")
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
    """Return *count* scenarios; of each factor, each of *count* equal parts of its range, or levels, occurs once.

    McKay, Beckman, Conover, A Comparison of Three Methods for Selecting Values of Input Variables in the Analysis of
    Output from a Computer Code, Technometrics 21 (1979).
    """
    columns = {}
    for name, levels in factors.items():
        # Seeded, so that the file has the same scenarios everywhere.
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
