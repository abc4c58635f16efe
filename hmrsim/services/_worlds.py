"""Worlds as simulation_interfaces sees them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import Resource, WorldResource
from hmrsim.world.writing import to_json

if TYPE_CHECKING:
    from hmrsim.world.model import World


def resource_of(world: World) -> WorldResource:
    """Return a world that is loaded: its own text, as the file that it came from may be on another machine."""
    description = f"{len(world.robots)} robots, {len(world.items)} items, {len(world.waypoints)} waypoints"
    return WorldResource(
        name=world.name, world_resource=Resource(resource_string=to_json(world)), description=description
    )
