"""Simpler values of an injection, such as a shorter duration or the first moment, and smaller worlds."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

from hmrsim.components.battery import BatterySettings
from hmrsim.fault_search.schedule import CHANGE

if TYPE_CHECKING:
    from hmrsim.fault_search.schedule import Injection
    from hmrsim.world.model import World

_SECONDS: Final = (1.0, 5.0, 10.0, 30.0, 60.0)
"""Durations that are easy to read."""

_FACTORS: Final = (0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 1.2, 1.5, 2.0, 5.0, 10.0, 100.0)
"""The factors by which a robot's own value may be changed instead, the smallest change first, down and up."""
_ROBOTS: Final = re.compile(r"robots\.(\"[^\"]+\"|[^.]+)\.(base\.speed|components\.battery\.(capacity|initial_charge))")

_EARLIER: Final = 10
"""The number of the last event of its kind that is tried as an earlier anchor."""


def simpler(injection: Injection, world: World | None = None) -> Iterator[Injection]:
    """Yield the injection with one simpler value, the simplest first; a change of *world* with a smaller change."""
    if world is not None and injection.family == CHANGE:
        yield from _smaller_changes(injection, world)
    when = dict(injection.anchor)
    for spec in _anchors(when):
        yield injection.replaced(when=spec)
    if injection.spec.get("count", 1) > 1:
        yield injection.replaced(count=1)
    for name in ("duration", "restart_after"):
        seconds = injection.spec.get(name)
        if isinstance(seconds, (int, float)):
            yield from (injection.replaced(**{name: each}) for each in _SECONDS if each < seconds)


def _smaller_changes(injection: Injection, world: World) -> Iterator[Injection]:
    """Yield smaller changes of a robot's own values, the smallest first."""
    changed = injection.spec[CHANGE]
    own = {path: value for path in changed if (value := _own(path, world)) is not None}
    if not own or not all(isinstance(changed[path], (int, float)) for path in own):
        return
    path = next(iter(own))
    factor = changed[path] / own[path]
    for smaller in (each for each in _FACTORS if (1.0 < each < factor) or (factor < each < 1.0)):
        values = {key: float(f"{own[key] * smaller:.4g}") if key in own else value for key, value in changed.items()}
        yield injection.replaced(change=values)


def _own(path: str, world: World) -> float | None:
    """Return a robot's own value at a path, its speed or a value of its battery; None for other paths."""
    match = _ROBOTS.fullmatch(path)
    robot = world.robots.get(match[1].strip('"')) if match else None
    if match is None or robot is None:
        return None
    kind = world.robot_type(robot)
    if match[2] == "base.speed":
        return world.speed(kind.base)
    battery = BatterySettings.model_validate(kind.components.get("battery") or {})
    return battery.capacity if match[3] == "capacity" else battery.initial_charge


def _anchors(when: dict[str, Any]) -> Iterator[dict[str, Any]]:
    after = when.get("after", 0.0)
    if after:
        yield {key: value for key, value in when.items() if key != "after"}
        for digits in (0, 1):
            rounded = round(after, digits)
            if rounded not in (0.0, after):
                yield {**when, "after": rounded}
    nth = when.get("nth", 1)
    if nth > 1:
        yield {key: value for key, value in when.items() if key != "nth"}
    # At an earlier event, the injection may be enough alone.
    yield from ({**when, "nth": earlier} for earlier in range(2, min(nth, _EARLIER)))


Part = tuple[str, Any]
"""A key of a world, and the name of an entry of its mapping, or the index of one in its list."""

_NAMED: Final = ("robots", "items", "lifts", "doors", "docks", "places")
_LISTED: Final = ("demand", "faults", "walls", "lanes")

ROUNDS: Final = (("robots",), ("demand", "items", "faults"), ("lifts", "doors", "docks", "places", "walls"), ("lanes",))
"""The keys whose entries are left out in one round, in this order."""


def parts_of(definition: Mapping[str, Any], keys: Iterable[str]) -> list[Part]:
    """Return the parts of a world under some keys, in order."""
    found: list[Part] = []
    for key in keys:
        entries = definition.get(key) or ()
        found += [(key, name) for name in (entries if key in _NAMED else range(len(entries)))]
    return found


def restricted(definition: Mapping[str, Any], keys: Iterable[str], kept: Iterable[Part]) -> dict[str, Any]:
    """Return a world reduced to the kept entries, without waypoints that no lane reaches."""
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
    """Return whether the name of a part is among *names*, or the part is a lane between two of them."""
    key, entry = part
    if key == "lanes":
        return {*_ends(definition[key][entry])} <= {*names}
    return key in _NAMED and entry in names


def tidied(definition: Mapping[str, Any], names: Collection[str] = ()) -> dict[str, Any]:
    """Return a world without isolated waypoints and unused robot types; waypoints in *names* stay."""
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
