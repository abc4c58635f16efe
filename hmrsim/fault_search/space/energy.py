"""How little a battery may be left with so that a failure is still the controller's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.components.battery import BatterySettings

if TYPE_CHECKING:
    from hmrsim.world.model import World

_RESERVE: Final = 1.5
"""How much of what a robot uses without faults it is left with: waits and detours take more."""


class Draw(NamedTuple):
    """What a robot takes from its battery, as shares of its capacity.

    Attributes:
        whole: The most from one charge to the next.
        goal: The most while one goal is executed.
    """

    whole: float = 0.0
    goal: float = 0.0


def battery_of(world: World, robot: str) -> BatterySettings | None:
    """Return the settings of a robot's battery; None if it has none."""
    settings = world.robot_type(world.robots[robot]).components.get("battery")
    return None if settings is None else BatterySettings.model_validate(settings)


def share_at_start(battery: BatterySettings) -> float:
    """Return the share of its capacity that a battery has at the start."""
    return 1.0 if battery.initial_charge is None else battery.initial_charge / battery.capacity


def has_charger(world: World) -> bool:
    """Return whether batteries can be charged in a world."""
    return any(dock.charges for dock in world.docks.values())


def needs_of(world: World, draws: Mapping[str, Draw]) -> dict[str, float]:
    """Return the share of its capacity that each robot with a battery needs at the start.

    With less no controller could do the mission. Where there is a charger, a controller can go there between any two
    goals: then a full battery has to last for the longest goal and the way back, and a low one for the longest goal.
    Without a charger it has to last for the whole mission.

    Args:
        world: The world.
        draws: What each robot takes from its battery in the run without faults.
    """
    needs = {}
    for name in world.robots:
        battery = battery_of(world, name)
        draw = draws.get(name)
        if battery is not None and draw is not None:
            low = draw.goal / battery.low if battery.low else 0.0
            used = max(2 * draw.goal, low) if has_charger(world) else draw.whole
            needs[name] = battery.stops_below + used * _RESERVE
    return needs
