"""A check: a world, a controller, properties, and the space of faults and other injections to search."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import HmrsimError
from hmrsim.fault_search.schedule import changes_in, overlays_of, with_faults
from hmrsim.navigation.cache import LruCache
from hmrsim.properties.compiler import compares
from hmrsim.settings.run import RunSettings
from hmrsim.world.overlays.overlay import overlay_of
from hmrsim.world.writing import native_data
from hmrsim.world_checks.loading import BaseWorld, base_world, world_of

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.errors import Problem
    from hmrsim.fault_search.model import CheckFile
    from hmrsim.fault_search.schedule import Case
    from hmrsim.properties import Properties
    from hmrsim.properties.results import Reference
    from hmrsim.trials.model import Controller
    from hmrsim.world.model import World
    from hmrsim.world.overlays.overlay import Overlay

_KEPT_WORLDS: Final = 64
"""The number of changed worlds that a process keeps."""


@dataclass(frozen=True, eq=False)
class Check:
    """A check that can be run, in this process or in a worker.

    Attributes:
        place: Its file as the user named it, or ``command line``; for errors.
        folder: The folder of the controller's files.
        file: The content of its file.
        source: The file of the world, or the name of a shipped one; None if *file* has the world itself.
        properties: The properties that have to hold.
        limit: Simulated seconds in which the controller has to end.
        reference: The items at the end of the run without faults, once it was made, if a property needs them.
        warnings: Parts of the check without an effect, such as a property of something that can't happen in this world.
    """

    place: str
    folder: Path
    file: CheckFile
    source: str | None
    properties: Properties
    limit: float
    reference: Reference | None = None
    warnings: tuple[Problem, ...] = ()
    _worlds: LruCache[str, World] = field(default_factory=partial(LruCache, _KEPT_WORLDS), compare=False, repr=False)

    def __hash__(self) -> int:
        """Return the hash of everything that decides its runs."""
        return hash(self.hash)

    def __eq__(self, other: object) -> bool:
        """Return whether the runs of another check are the same."""
        return isinstance(other, Check) and other.hash == self.hash

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for another process, without the cached worlds."""
        return {name: getattr(self, name) for name in self.__dataclass_fields__ if name != "_worlds"} | {
            "_worlds": LruCache(_KEPT_WORLDS)
        }

    @property
    def treatment(self) -> Controller:
        """The controller under test."""
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
        first = [overlay_of(self.file.overlay, self.place)] if self.file.overlay else []
        if isinstance(self.file.world, dict):
            return world_of(dict(self.file.world), self.place, [*first, *overlays])
        return self._base.load([*first, *overlays]).world

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
