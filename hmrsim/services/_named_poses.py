"""The poses of a world that have a name: its waypoints, places and docks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.geometry import Pose
from hmrsim.interfaces.simulation_interfaces import NamedPose
from hmrsim.services._entities import pose_message
from hmrsim.world.derived import Derived

if TYPE_CHECKING:
    from hmrsim.world.model import World


def _named_poses(world: World) -> dict[str, NamedPose]:
    tags: dict[str, list[str]] = {}
    for name in world.places:
        tags.setdefault(name, []).append("place")
    for name, dock in world.docks.items():
        tags.setdefault(name, []).extend(dict.fromkeys(("dock", dock.type)))
    for name in world.waypoints:
        tags.setdefault(name, []).append("waypoint")
    return {
        name: NamedPose(
            name=name, description=" and ".join(found), tags=found, pose=pose_message(Pose(*world.point(name)))
        )
        for name, found in tags.items()
    }


named_poses: Final = Derived(_named_poses, "places", "docks", "waypoints")
"""Returns all of them by name; what has one name has one point."""
