"""How little a battery may be left with so that a failure is still the controller's."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Final

from hmrsim.components.battery import BatterySettings

if TYPE_CHECKING:
    from hmrsim.world.model import World

_RESERVE: Final = 1.5
"""How much of what a robot uses without faults it is left with: waits and detours take more."""


def battery_of(world: World, robot: str) -> BatterySettings | None:
    """Return the settings of a robot's battery; None if it has none."""
    settings = world.robot_type(world.robots[robot]).components.get("battery")
    return None if settings is None else BatterySettings.model_validate(settings)


def needs_of(world: World, drawn: Mapping[str, float]) -> dict[str, float]:
    """Return the share of its capacity that each robot with a battery needs from one charge to the next.

    With less no controller could do the mission, at least not as it does it without faults.

    Args:
        world: The world.
        drawn: What each robot uses without charging in the run without faults.
    """
    return {
        name: battery.stops_below + drawn.get(name, 0.0) * _RESERVE
        for name in world.robots
        if (battery := battery_of(world, name)) is not None
    }
