"""Simpler values of a thing: a shorter time, the first moment, fewer goals."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, Final

from hmrsim.components.battery import BatterySettings
from hmrsim.fault_search.schedules.thing import CHANGE

if TYPE_CHECKING:
    from hmrsim.fault_search.schedules.thing import Thing
    from hmrsim.world.model import World

_SECONDS: Final = (1.0, 5.0, 10.0, 30.0, 60.0)
"""Durations that are easy to read."""


_FACTORS: Final = (0.95, 0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 1.2, 1.5, 2.0, 5.0, 10.0, 100.0)
"""By how much what a robot has by itself may be changed instead, the least change first, down and up."""
_ROBOTS: Final = re.compile(r"robots\.(\"[^\"]+\"|[^.]+)\.(base\.speed|components\.battery\.(capacity|initial_charge))")

_EARLIER: Final = 10
"""Up to which of its kind an earlier event is tried, one after the other."""


def simpler(thing: Thing, world: World | None = None) -> Iterator[Thing]:
    """Yield the same thing with one simpler value, the simplest first; of a change of *world* a smaller one."""
    if world is not None and thing.family == CHANGE:
        yield from _smaller_changes(thing, world)
    when = dict(thing.anchor)
    for said in _anchors(when):
        yield thing.replaced(when=said)
    if thing.said.get("count", 1) > 1:
        yield thing.replaced(count=1)
    for name in ("duration", "restart_after"):
        seconds = thing.said.get(name)
        if isinstance(seconds, (int, float)):
            yield from (thing.replaced(**{name: each}) for each in _SECONDS if each < seconds)


def _smaller_changes(thing: Thing, world: World) -> Iterator[Thing]:
    """Yield a change by less of what a robot has by itself, the least one first."""
    changed = thing.said[CHANGE]
    own = {path: value for path in changed if (value := _own(path, world)) is not None}
    if not own or not all(isinstance(changed[path], (int, float)) for path in own):
        return
    path = next(iter(own))
    factor = changed[path] / own[path]
    for smaller in (each for each in _FACTORS if (1.0 < each < factor) or (factor < each < 1.0)):
        values = {key: float(f"{own[key] * smaller:.4g}") if key in own else value for key, value in changed.items()}
        yield thing.replaced(change=values)


def _own(path: str, world: World) -> float | None:
    """Return what a robot has by itself of what a path says: its speed, or a number of its battery; None for others."""
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
    # At an earlier one the thing may be enough alone.
    yield from ({**when, "nth": earlier} for earlier in range(2, min(nth, _EARLIER)))
