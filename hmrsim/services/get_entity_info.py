"""Return the category, tags and description of an entity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import GetEntityInfo, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._entities import info_of, unknown
from hmrsim.services._results import OK

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: GetEntityInfo.Request) -> GetEntityInfo.Response:
    entity = simulator.roster.find(request.entity)
    if entity is None:
        return GetEntityInfo.Response(result=unknown(simulator, request.entity))
    return GetEntityInfo.Response(result=OK, info=info_of(simulator, entity))


SERVICE = Service(
    name="get_entity_info",
    request=GetEntityInfo.Request,
    response=GetEntityInfo.Response,
    serve=_serve,
    features=(SimulatorFeatures.ENTITY_INFO_GETTING,),
    example={"entity": "tester"},
)
