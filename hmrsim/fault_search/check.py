"""A check: a world, a controller, properties, and the space of injections to search; and the models of its files."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Annotated, Any, Final, Literal

from pydantic import BeforeValidator, Field

from hmrsim.caches import LruCache
from hmrsim.documents.document import LineOf, no_line
from hmrsim.errors import HmrsimError
from hmrsim.fault_search.schedule import changes_in, overlays_of, with_faults
from hmrsim.properties.compiler import compares
from hmrsim.settings.run import RunSettings
from hmrsim.trials.model import Controller, Count, Limits, Part, Seconds
from hmrsim.world.overlays.overlay import overlay_of
from hmrsim.world.writing import native_data
from hmrsim.world_checks.loading import BaseWorld, base_world, world_of

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.errors import Problem
    from hmrsim.fault_search.schedule import Case
    from hmrsim.properties import Properties
    from hmrsim.properties.results import Reference
    from hmrsim.world.model import World
    from hmrsim.world.overlays.overlay import Overlay


Family = Literal["faults", "changes", "disturbances"]

OPT_IN: Final = ("item_lost", "second_controller", "simulation_reset")
"""The kinds that happen only if a check asks for them, since few controllers can handle them."""


class Space(Part):
    """The space of injections to search; by default everything that can happen to the robots of the world.

    Attributes:
        families: Faults, changes of the world, and disturbances of the connection and the controller.
        only: The kinds to try; None for all.
        without: Kinds to leave out.
        also: Kinds to add that are left out by default: ``item_lost``, ``second_controller``, ``simulation_reset``.
        spare: Robots, doors, docks and items to leave alone.
        at_most: The maximum number of injections in a schedule.
        durations: The durations of injections in seconds.
        weights: The frequency of a kind, relative to 1.
        further: Custom injections; a list of values stands for each value, and a robot ``*`` for each robot.
    """

    families: tuple[Family, ...] = ("faults", "changes", "disturbances")
    only: tuple[str, ...] | None = None
    without: tuple[str, ...] = ()
    also: tuple[str, ...] = ()
    spare: tuple[str, ...] = ()
    at_most: Annotated[int, Field(strict=True, ge=1, le=100)] = 3
    durations: Annotated[tuple[Seconds, ...], Field(min_length=1)] = (5.0, 30.0)
    weights: dict[str, Annotated[float, Field(strict=True, gt=0, le=1e6)]] = Field(default={})
    further: tuple[dict[str, Any], ...] = ()


_BUDGET: Final = re.compile(r"(\d+(?:\.\d+)?) ?(s|min|m|h)?")
_UNITS: Final = {None: 1.0, "s": 1.0, "min": 60.0, "m": 60.0, "h": 3600.0}


def seconds_of(value: Any) -> Any:
    """Return the wall seconds of a text such as ``90 s``, ``10m`` or ``1 h``; other values unchanged.

    Raises:
        ValueError: The text is not a time.
    """
    if not isinstance(value, str):
        return float(value) if type(value) is int else value
    match = _BUDGET.fullmatch(value.strip())
    if match is None:
        raise ValueError(f"expected a time such as 90s, 10m or 1h, got {value!r}")
    return float(match[1]) * _UNITS[match[2]]


class Budget(Part):
    """The budget of a search.

    Attributes:
        time: Wall seconds; in a file also ``90 s``, ``10m`` or ``1 h``.
        runs: The number of runs; searches with only this limit are reproducible.
    """

    time: Annotated[float, BeforeValidator(seconds_of), Field(strict=True, gt=0, le=1e7)] = 600.0
    runs: Count | None = None


def _budget(value: Any) -> Any:
    """Return a budget for a bare time; other values unchanged."""
    return {"time": value} if isinstance(value, (str, int, float)) and not isinstance(value, bool) else value


class CheckFile(Part):
    """The file of a check: a world, a controller, the properties that must hold, and the space to search."""

    name: Annotated[str, Field(min_length=1, max_length=100)] | None = None
    world: str | dict[str, Any] = Field(description="A world file, the name of a shipped world, or a world itself.")
    controller: Controller
    overlay: dict[str, Any] = Field(default={}, description="Changes to the world, as in an overlay file.")
    properties: str | dict[str, Any] | None = Field(
        default=None, description="A file of properties, or its content; by default only the built-in ones."
    )
    space: Space = Space()
    limits: Limits = Limits()
    budget: Annotated[Budget, BeforeValidator(_budget)] = Budget()
    seed: Annotated[int, Field(strict=True)] = 0
    world_seed: Annotated[int, Field(strict=True)] | None = Field(
        default=None, description="The seed of the runs; by default the world's own."
    )


class Failed(Part):
    """The failure of a run.

    Attributes:
        property: The property that was violated.
        reason: The reason, without times and names.
    """

    property: str
    reason: str


class ReproFile(CheckFile):
    """The file of a failure: a check with the schedule that causes it."""

    repro: Literal[1] = Field(description="The version of the format.")
    schedule: tuple[dict[str, Any], ...] = Field(description="The injections: faults, changes and disturbances.")
    failure: Failed
    folder: str = Field(
        default=".", description="The folder of the controller's files, relative to the folder of this file."
    )
    trace: str = Field(default="", description="SHA-256 of the run's trace; empty if unknown.")
    left_out: str = Field(
        default="", description="What the search has left out of the world of the check, in words; empty for nothing."
    )


_KEPT_WORLDS: Final = 64
"""The number of changed worlds that a process keeps."""


@dataclass(frozen=True, eq=False)
class Check:
    """A check that can be run, in this process or in a worker.

    Attributes:
        place: Its file as the user named it, or ``command line``; for errors.
        folder: The folder of the controller's files.
        source: The file of the world, or the name of a shipped one; None if *file* has the world itself.
        limit: Simulated seconds in which the controller has to end.
        reference: The items at the end of the run without faults, once it was made, if a property needs them.
        warnings: Parts of the check without an effect, such as a property of something that can't happen in this world.
        line: Returns the line of a field of its file, in the process that has read it.
    """

    place: str
    folder: Path
    file: CheckFile
    source: str | None
    properties: Properties
    limit: float
    reference: Reference | None = None
    warnings: tuple[Problem, ...] = ()
    line: LineOf = field(default=no_line, repr=False)
    _worlds: LruCache[str, World] = field(default_factory=partial(LruCache, _KEPT_WORLDS), compare=False, repr=False)

    def __hash__(self) -> int:
        """Return the hash of everything that decides its runs."""
        return hash(self.hash)

    def __eq__(self, other: object) -> bool:
        """Return whether the runs of another check are the same."""
        return isinstance(other, Check) and other.hash == self.hash

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for another process, without the cached worlds and the lines."""
        state = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return state | {"line": no_line, "_worlds": LruCache(_KEPT_WORLDS)}

    @property
    def treatment(self) -> Controller:
        """The controller whose runs are checked."""
        return self.file.controller

    @property
    def name(self) -> str:
        """The name in the file, or that of the world."""
        return self.file.name or self.world.name

    @cached_property
    def settings(self) -> RunSettings:
        """The settings of its runs."""
        return RunSettings(seed=self.file.world_seed, duration=self.limit, clock="lockstep")

    @cached_property
    def compares(self) -> bool:
        """True if a property compares runs with the one without faults."""
        return compares(self.properties)

    @cached_property
    def named(self) -> frozenset[str]:
        """All words in its properties, among them the names of robots, items and places."""
        return frozenset(_texts(self.properties.model_dump(mode="json", by_alias=True, exclude_defaults=True)))

    @cached_property
    def hash(self) -> str:
        """SHA-256 of everything but the case that decides the outcome of a run."""
        said = self.file.model_dump(mode="json", exclude={"budget", "space", "seed", "name", "properties"})
        properties = self.properties.model_dump(mode="json", by_alias=True)
        text = json.dumps([said, properties, self.limit, str(self.folder), self.reference], sort_keys=True, default=str)
        return hashlib.sha256(text.encode()).hexdigest()

    @cached_property
    def world(self) -> World:
        """The world, without a schedule.

        Raises:
            WorldError: It is invalid.
        """
        return self._laid(())

    @cached_property
    def definition(self) -> dict[str, Any]:
        """The world as a native file has it."""
        return native_data(self.world)

    def world_of(self, case: Case) -> World:
        """Return the world of a case, with its schedule.

        Raises:
            WorldError: It is invalid.
        """
        if case.definition is None:
            changes = changes_in(case.schedule)
            key = "/".join(change.key for change in changes)
            world = self._worlds.get(key, lambda: self._laid(overlays_of(changes))) if changes else self.world
        else:
            world = world_of(dict(case.definition), "world", overlays_of(case.schedule))
        return with_faults(world, case.schedule)

    def _laid(self, overlays: Sequence[Overlay]) -> World:
        first = []
        if self.file.overlay:
            first = [overlay_of(self.file.overlay, self.place, line=self._lines_below("overlay"))]
        if isinstance(self.file.world, dict):
            line = self._lines_below("world")
            return world_of(dict(self.file.world), self.place, [*first, *overlays], line=line)
        return self._base.load([*first, *overlays]).world

    def _lines_below(self, key: str) -> LineOf:
        return lambda path: self.line((key, *path))

    @cached_property
    def _base(self) -> BaseWorld:
        return base_world(self.source or "")

    def runnable(self, case: Case) -> str:
        """Return the reason why a case can't be run; empty if it can."""
        try:
            self.world_of(case)
        except (HmrsimError, ValueError) as error:
            return str(error)
        return ""


def _texts(value: Any) -> Iterator[str]:
    """Yield all keys and texts in plain values."""
    if isinstance(value, str):
        yield value
    elif isinstance(value, Mapping):
        for key, each in value.items():
            yield str(key)
            yield from _texts(each)
    elif isinstance(value, (list, tuple)):
        for each in value:
            yield from _texts(each)
