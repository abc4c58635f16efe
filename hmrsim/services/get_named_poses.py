"""Return the named poses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import GetNamedPoses, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._entities import has_tags
from hmrsim.services._named_poses import named_poses
from hmrsim.services._results import OK

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: GetNamedPoses.Request) -> GetNamedPoses.Response:
    poses = [pose for pose in named_poses(simulator.world).values() if has_tags(pose.tags, request.tags)]
    return GetNamedPoses.Response(result=OK, poses=poses)


SERVICE = Service(
    name="get_named_poses",
    request=GetNamedPoses.Request,
    response=GetNamedPoses.Response,
    serve=_serve,
    features=(SimulatorFeatures.NAMED_POSES,),
    example={"tags": {"tags": ["waypoint"]}},
)
