"""Return the bounds of a named pose: there are none, as poses are points here."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead
from hmrsim.interfaces.simulation_interfaces import GetNamedPoseBounds, Result, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._named_poses import named_poses
from hmrsim.services._results import OK, failed

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: GetNamedPoseBounds.Request) -> GetNamedPoseBounds.Response:
    known = named_poses(simulator.world)
    if request.name in known:
        return GetNamedPoseBounds.Response(result=OK)
    why = f"no pose {request.name!r}{instead(request.name, known, verb='there are:')}"
    return GetNamedPoseBounds.Response(result=failed(why, Result.RESULT_NOT_FOUND))


SERVICE = Service(
    name="get_named_pose_bounds",
    request=GetNamedPoseBounds.Request,
    response=GetNamedPoseBounds.Response,
    serve=_serve,
    features=(SimulatorFeatures.POSE_BOUNDS,),
    example={"name": "there"},
)
