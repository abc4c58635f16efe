"""Return the worlds that can be loaded by name alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import (
    GetAvailableWorlds,
    Resource,
    Result,
    SimulatorFeatures,
    WorldResource,
)
from hmrsim.services import Service
from hmrsim.services._results import OK, failed
from hmrsim.world.shipped import shipped_maps

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_Response = GetAvailableWorlds.Response


def _serve(_simulator: Simulator, request: GetAvailableWorlds.Request) -> GetAvailableWorlds.Response:
    if request.filter.tags:
        return _Response(result=failed("worlds have no tags here", Result.RESULT_FEATURE_UNSUPPORTED))
    result = OK
    if request.additional_sources:
        sources = ", ".join(request.additional_sources)
        why = f"unknown sources: {sources}; files are loaded by their path, with --allow-files"
        if not request.continue_on_error:
            return _Response(result=failed(why, Result.RESULT_NOT_FOUND))
        result = Result(result=Result.RESULT_OK, error_message=why)
    worlds = [WorldResource(name=name, world_resource=Resource(uri=name)) for name in shipped_maps()]
    return _Response(result=result, worlds=worlds)


SERVICE = Service(
    name="get_available_worlds",
    request=GetAvailableWorlds.Request,
    response=GetAvailableWorlds.Response,
    serve=_serve,
    features=(SimulatorFeatures.AVAILABLE_WORLDS,),
)
