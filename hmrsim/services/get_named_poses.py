"""Return the named poses."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.simulation_interfaces import GetNamedPoses, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._entities import has_tags
from hmrsim.services._named_poses import named_poses
from hmrsim.services._results import OK
from hmrsim.world.derived import Derived

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World


def _serve(simulator: Simulator, request: GetNamedPoses.Request) -> GetNamedPoses.Response:
    if not request.tags.tags:
        return _all_poses(simulator.world)
    poses = [pose for pose in named_poses(simulator.world).values() if has_tags(pose.tags, request.tags)]
    return GetNamedPoses.Response(result=OK, poses=poses)


def _every_pose(world: World) -> GetNamedPoses.Response:
    return GetNamedPoses.Response(result=OK, poses=[*named_poses(world).values()])


_all_poses: Final = Derived(_every_pose, "places", "docks", "waypoints")


SERVICE = Service(
    name="get_named_poses",
    request=GetNamedPoses.Request,
    response=GetNamedPoses.Response,
    serve=_serve,
    features=(SimulatorFeatures.NAMED_POSES,),
    example={"tags": {"tags": ["waypoint"]}},
)
