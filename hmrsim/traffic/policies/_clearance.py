"""Capacities of slots, in vehicles."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hmrsim.world.model import Waypoint

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World


def rooms_of_waypoints(world: World, default: int | None) -> dict[str, float]:
    """Return how many vehicles may be at each waypoint.

    A docked robot stands at the waypoint of its dock, so that the waypoint has the dock's capacity. A robot that waits
    for a lift stands beside the door, and lets others get out.

    Args:
        world: Its waypoints; docks without a place are left out.
        default: The capacity of waypoints that state none; None for any number.
    """
    stated: dict[str, int | None] = {
        name: at.capacity for name, at in world.waypoints.items() if isinstance(at, Waypoint)
    }
    names = {point: name for name, point in world.points.items()}
    for dock in world.docks:
        name, capacity = names.get(_point(world, dock) or (math.nan, math.nan)), world.docks[dock].capacity
        if name is not None and capacity > 1:
            room = stated.get(name) or default
            stated[name] = room and max(room, capacity)
    stops = {stop for lift in world.lifts.values() for stop in lift.stops}
    return {name: stated.get(name) or (None if name in stops else default) or math.inf for name in world.waypoints}


def _point(world: World, dock: str) -> Point | None:
    try:
        return world.dock_point(dock)
    except KeyError:
        return None
