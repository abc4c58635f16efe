"""The changes of a world that can be tried: slow robots, small batteries, other demand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from hmrsim.components.battery import BatterySettings

if TYPE_CHECKING:
    from hmrsim.world.model import World

_SLOW: Final = 0.3
"""Share of its speed that a slow robot has."""
_QUICK: Final = 1e4
"""Times its speed with which a robot's goals end almost at once."""
_SMALL: Final = 0.5
"""Share of its capacity that a small battery has."""
_BURST: Final = 0.01
"""Seconds between the orders of a burst."""
_INSTANT: Final = 1e-9
"""Seconds between orders that come at one instant, as nearly as can be said."""

KINDS: Final[Mapping[str, str]] = {
    "speed": "robots that are slow, or so quick that their goals end almost at once",
    "capacity": "batteries with half of their capacity",
    "arrives": "orders that come in a burst",
    "absent": "no orders at all",
}
"""The kinds of changes, each with what it is."""


def changes_of(world: World, robots: Sequence[str]) -> Iterator[dict[str, Any]]:
    """Yield the changes that can be tried, in plain values.

    Args:
        world: The world.
        robots: The robots that the controller uses.
    """
    for name in robots:
        kind = world.robot_type(world.robots[name])
        speed = world.speed(kind.base)
        for factor in (_SLOW, _QUICK):
            yield _change(f"robots.{_quoted(name)}.base.speed", speed * factor)
        if kind.components.get("battery") is not None:
            yield from _small_battery(name, kind.components["battery"])
    for i, demand in enumerate(world.demand):
        yield _change(f"demand.{i}.arrives", _BURST)
        if demand.count is not None and demand.count > 1:
            yield {"change": {f"demand.{i}.arrives": _INSTANT, f"demand.{i}.first": 0.0}}
        yield {"change": {f"~demand.{i}": None}}


def _small_battery(name: str, settings: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    battery = BatterySettings.model_validate(settings)
    path = f"robots.{_quoted(name)}.components.battery"
    change: dict[str, Any] = {f"{path}.capacity": battery.capacity * _SMALL}
    if battery.initial_charge is not None:
        change[f"{path}.initial_charge"] = battery.initial_charge * _SMALL
    yield {"change": change}


def _change(path: str, value: Any) -> dict[str, Any]:
    return {"change": {path: value}}


def _quoted(name: str) -> str:
    return f'"{name}"' if "." in name else name
