"""The changes of a world that can be tried: slow robots, small batteries, other demand."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, Final

from hmrsim.fault_search.space.energy import battery_of, share_at_start

if TYPE_CHECKING:
    from hmrsim.components.battery import BatterySettings
    from hmrsim.world.model import World

_SLOW: Final = 0.3
"""Share of its speed that a slow robot has."""
_QUICK: Final = 1e4
"""Times its speed with which a robot's goals end almost at once."""
_SMALL: Final = 0.5
"""Share of its capacity that a small battery has."""
_HARDLY: Final = 0.95
"""A share from which on a change is not worth a run."""
_BURST: Final = 0.01
"""Seconds between the orders of a burst."""
_INSTANT: Final = 1e-9
"""Seconds between orders that come at one instant, as nearly as can be said."""

KINDS: Final[Mapping[str, str]] = {
    "speed": "robots that are slow, or so quick that their goals end almost at once",
    "capacity": "batteries with half of their capacity, or as much more as the mission needs",
    "arrives": "orders that come in a burst",
    "absent": "no orders at all",
}
"""The kinds of changes, each with what it is."""


def changes_of(world: World, robots: Sequence[str], needs: Mapping[str, float]) -> Iterator[dict[str, Any]]:
    """Yield the changes that can be tried, in plain values.

    Args:
        world: The world.
        robots: The robots that the controller uses.
        needs: The share of its battery's capacity that each robot needs at the start.
    """
    for name in robots:
        speed, battery = world.speed(world.robot_type(world.robots[name]).base), battery_of(world, name)
        # One that is slow uses its battery for longer, up to as much as the speed is less.
        least = 0.0 if battery is None else needs.get(name, 0.0) / (share_at_start(battery) or 1.0)
        slow = max(_SLOW, least)
        for factor in (slow, _QUICK) if slow < _HARDLY else (_QUICK,):
            yield _change(f"robots.{_quoted(name)}.base.speed", _plain(speed * factor))
        if battery is not None and max(_SMALL, least) < _HARDLY:
            yield _small_battery(name, battery, max(_SMALL, least))
    for i, demand in enumerate(world.demand):
        yield _change(f"demand.{i}.arrives", _BURST)
        if demand.count is not None and demand.count > 1:
            yield {"change": {f"demand.{i}.arrives": _INSTANT, f"demand.{i}.first": 0.0}}
        yield {"change": {f"~demand.{i}": None}}


def _small_battery(name: str, battery: BatterySettings, factor: float) -> dict[str, Any]:
    path = f"robots.{_quoted(name)}.components.battery"
    change: dict[str, Any] = {f"{path}.capacity": _plain(battery.capacity * factor)}
    if battery.initial_charge is not None:
        change[f"{path}.initial_charge"] = min(change[f"{path}.capacity"], _plain(battery.initial_charge * factor))
    return {"change": change}


def _plain(number: float) -> float:
    """Return a number with few digits."""
    return float(f"{number:.4g}")


def _change(path: str, value: Any) -> dict[str, Any]:
    return {"change": {path: value}}


def _quoted(name: str) -> str:
    return f'"{name}"' if "." in name else name
