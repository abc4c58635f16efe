"""Services for the named poses of a world: its waypoints, places and docks."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.diagnostics import instead
from hmrsim.geometry import Pose
from hmrsim.interfaces.simulation_interfaces import (
    GetNamedPoseBounds,
    GetNamedPoses,
    NamedPose,
    Result,
    SimulatorFeatures,
)
from hmrsim.services import OK, Service, failed
from hmrsim.services._entities import has_tags, pose_message
from hmrsim.world.derived import Derived

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World


def _read_named_poses(world: World) -> dict[str, NamedPose]:
    """Return the named poses; a name that is used twice, such as of a dock at a place, has one point."""
    tags: dict[str, list[str]] = {}
    for name in world.places:
        tags.setdefault(name, []).append("place")
    for name, dock in world.docks.items():
        tags.setdefault(name, []).extend(dict.fromkeys(("dock", dock.type)))
    for name in world.waypoints:
        tags.setdefault(name, []).append("waypoint")
    return {
        name: NamedPose(
            name=name, description=" and ".join(kinds), tags=kinds, pose=pose_message(Pose(*world.point(name)))
        )
        for name, kinds in tags.items()
    }


_named_poses: Final = Derived(_read_named_poses, "places", "docks", "waypoints")
_all_poses: Final = Derived(
    lambda world: GetNamedPoses.Response(result=OK, poses=[*_named_poses(world).values()]),
    "places",
    "docks",
    "waypoints",
)


def _get_named_poses(simulator: Simulator, request: GetNamedPoses.Request) -> GetNamedPoses.Response:
    if not request.tags.tags:
        return _all_poses(simulator.world)
    poses = [pose for pose in _named_poses(simulator.world).values() if has_tags(pose.tags, request.tags)]
    return GetNamedPoses.Response(result=OK, poses=poses)


def _get_named_pose_bounds(simulator: Simulator, request: GetNamedPoseBounds.Request) -> GetNamedPoseBounds.Response:
    # Poses are points here, so they have no bounds.
    known = _named_poses(simulator.world)
    if request.name in known:
        return GetNamedPoseBounds.Response(result=OK)
    why = f"no pose {request.name!r}{instead(request.name, known, verb='there are:')}"
    return GetNamedPoseBounds.Response(result=failed(why, Result.RESULT_NOT_FOUND))


SERVICES = (
    Service(
        name="get_named_poses",
        request=GetNamedPoses.Request,
        response=GetNamedPoses.Response,
        serve=_get_named_poses,
        features=(SimulatorFeatures.NAMED_POSES,),
        example={"tags": {"tags": ["waypoint"]}},
    ),
    Service(
        name="get_named_pose_bounds",
        request=GetNamedPoseBounds.Request,
        response=GetNamedPoseBounds.Response,
        serve=_get_named_pose_bounds,
        features=(SimulatorFeatures.POSE_BOUNDS,),
        example={"name": "there"},
    ),
)
