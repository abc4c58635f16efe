"""How many robots there is room for."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hmrsim.world.model import Waypoint

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World


def rooms_of_waypoints(world: World, most: int | None) -> dict[str, float]:
    """Return how many robots may be at each waypoint.

    Whoever is docked at a waypoint stands there, so it has the room of its dock. Who waits for a lift stands beside
    its door, and lets others get out.

    Args:
        world: Its waypoints; docks that are nowhere are left out.
        most: Of waypoints of which nothing is said; None for any number.
    """
    said: dict[str, int | None] = {
        name: at.capacity for name, at in world.waypoints.items() if isinstance(at, Waypoint)
    }
    names = {point: name for name, point in world.points.items()}
    for dock in world.docks:
        name, capacity = names.get(_point(world, dock) or (math.nan, math.nan)), world.docks[dock].capacity
        if name is not None and capacity > 1:
            room = said.get(name) or most
            said[name] = room and max(room, capacity)
    stops = {stop for lift in world.lifts.values() for stop in lift.stops}
    return {name: said.get(name) or (None if name in stops else most) or math.inf for name in world.waypoints}


def _point(world: World, dock: str) -> Point | None:
    try:
        return world.dock_point(dock)
    except KeyError:
        return None
