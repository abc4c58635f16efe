"""The parts of a world that a failure may do without."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any, Final

Part = tuple[str, Any]
"""A key of a world, and the name of an entry of its mapping, or the index of one in its list."""

_NAMED: Final = ("robots", "items", "lifts", "doors", "docks", "places")
_LISTED: Final = ("demand", "faults", "walls", "lanes")

ROUNDS: Final = (("robots",), ("demand", "items", "faults"), ("lifts", "doors", "docks", "places", "walls"), ("lanes",))
"""The keys whose entries are left out together, in this order."""


def parts_of(definition: Mapping[str, Any], keys: Iterable[str]) -> list[Part]:
    """Return the parts of a world under some keys, in order."""
    found: list[Part] = []
    for key in keys:
        entries = definition.get(key) or ()
        found += [(key, name) for name in (entries if key in _NAMED else range(len(entries)))]
    return found


def restricted(definition: Mapping[str, Any], keys: Iterable[str], kept: Iterable[Part]) -> dict[str, Any]:
    """Return a world that has of some keys only what is kept, and no waypoint that nothing leads to any more."""
    parts = dict.fromkeys(kept)
    world = dict(definition)
    for key in keys:
        if key in world:
            world[key] = _entries(key, world[key], parts)
            if not world[key]:
                del world[key]
    return world


def _entries(key: str, entries: Any, kept: Mapping[Part, None]) -> Any:
    if key in _LISTED:
        return [entry for i, entry in enumerate(entries) if (key, i) in kept]
    return {name: entry for name, entry in entries.items() if (key, name) in kept}


def is_named(definition: Mapping[str, Any], part: Part, names: Collection[str]) -> bool:
    """Return whether a part of a world has one of some names, or is a lane between two of them."""
    key, entry = part
    if key == "lanes":
        return {*_ends(definition[key][entry])} <= {*names}
    return key in _NAMED and entry in names


def tidied(definition: Mapping[str, Any], names: Collection[str] = ()) -> dict[str, Any]:
    """Return a world without the waypoints that no lane touches, and without the robot types of no robot.

    Waypoints with some *names* stay.
    """
    touched = {end for lane in definition.get("lanes", ()) for end in _ends(lane)}
    touched |= {stop for lift in (definition.get("lifts") or {}).values() for stop in lift.get("stops", ())}
    at = {each.get("at") for key in _NAMED for each in (definition.get(key) or {}).values() if _is_named(each)}
    types = {robot.get("type") for robot in (definition.get("robots") or {}).values()}
    world = dict(definition)
    for key, wanted in (("waypoints", touched | at | {*names}), ("robot_types", types)):
        if key in world:
            world[key] = {name: entry for name, entry in world[key].items() if name in wanted}
            if not world[key]:
                del world[key]
    return world


def _is_named(entry: Any) -> bool:
    return isinstance(entry, Mapping) and isinstance(entry.get("at"), str)


def _ends(lane: Any) -> tuple[str, str]:
    return (lane["from"], lane["to"]) if isinstance(lane, Mapping) else (lane[0], lane[1])
