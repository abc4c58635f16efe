"""Schedules applied to worlds: changes as overlays, faults as those of the world."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from hmrsim.fault_search.schedules.thing import CHANGE, FAULT, Thing
from hmrsim.world.model import FaultEntry
from hmrsim.world.overlays.overlay import Overlay, overlay_of

if TYPE_CHECKING:
    from hmrsim.world.model import World


def changes_in(schedule: Iterable[Thing]) -> list[Thing]:
    """Return the changes of the world in a schedule."""
    return [thing for thing in schedule if thing.family == CHANGE]


def overlays_of(schedule: Iterable[Thing]) -> list[Overlay]:
    """Return the changes of a schedule, to be laid over a world before it is checked."""
    return [overlay_of(thing.said[CHANGE], "the schedule") for thing in changes_in(schedule)]


def with_faults(world: World, schedule: Sequence[Thing]) -> World:
    """Return a world to whose faults those of a schedule are added."""
    faults = [FaultEntry.model_validate(dict(thing.said)) for thing in schedule if thing.family == FAULT]
    return world.model_copy(update={"faults": (*world.faults, *faults)}) if faults else world
