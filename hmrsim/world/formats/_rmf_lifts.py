"""The lifts of an Open-RMF building: they stop at the waypoint in their cabin on each level that has a door to it."""

from __future__ import annotations

import cmath
from collections.abc import Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from hmrsim.world.formats._part import BadPart, Part

if TYPE_CHECKING:
    from hmrsim.world.formats._reading import Reading
    from hmrsim.world.formats._rmf_level import Level

_GAP = 0.05
"""Metres between cabin and shaft; a vertex in the shaft is in the lift."""

_MIN_STOPS = 2
"""Stops without which a lift leads nowhere."""


@dataclass(frozen=True)
class Shafts:
    """Where lifts can be.

    Attributes:
        levels: All levels by name; the waypoints of those that are read have names.
        reference: The level in whose drawing a lift is that does not say.
        down: Whether y points down in drawings.
    """

    levels: Mapping[str, Level]
    reference: Level
    down: bool


def lifts(reading: Reading, shafts: Shafts) -> dict[str, Any]:
    """Return the lifts, as in a world file."""
    found: dict[str, Any] = {}
    part = reading.root.get("lifts") or Part({})
    for name, lift in reading.attempt(lambda: list(part.entries())) or ():
        stops = reading.attempt(partial(_stops, shafts, lift))
        if stops is not None and len(stops) < _MIN_STOPS:
            reading.leave_out("lifts with no waypoints on two levels in their cabins", lift)
        elif stops is not None:
            found[name] = {"stops": stops}
            reading.origin(("lifts", name), lift)
    return found


def _stops(shafts: Shafts, lift: Part) -> list[str]:
    """Return the names of the waypoints where a lift stops, from below.

    Raises:
        BadPart: It doesn't say where it is, or a level is unknown.
    """
    drawn = complex(lift.want("x").number(), lift.want("y").number())
    own = lift.get("reference_floor_name")
    reference = _level(shafts, own, str(own.value)) if own and own.value else shafts.reference
    centre = reference.align(drawn.conjugate() if shafts.down else drawn)
    doors = lift.get("level_doors") or Part({})
    served = [_level(shafts, part, name) for name, part in doors.entries() if part.value]
    inside = (_in_cabin(lift, centre, level) for level in sorted(served, key=lambda level: level.elevation))
    return [name for name in inside if name]


def _level(shafts: Shafts, part: Part, name: str) -> Level:
    if name not in shafts.levels:
        raise BadPart(part, f"no level {name!r}; there are {', '.join(shafts.levels)}")
    return shafts.levels[name]


def _in_cabin(lift: Part, centre: complex, level: Level) -> str:
    """Return the waypoint of a level that is nearest to the centre of a lift's cabin; empty if none is in it."""
    width, depth, yaw = (lift.want(key).number() for key in ("width", "depth", "yaw"))
    inside = []
    for index, name in level.names.items():
        away = (level.at(index) - level.shift - centre) * cmath.rect(1.0, -yaw)
        if abs(away.real) <= width / 2.0 + _GAP and abs(away.imag) <= depth / 2.0 + _GAP:
            inside.append((abs(away), name))
    return min(inside)[1] if inside else ""
