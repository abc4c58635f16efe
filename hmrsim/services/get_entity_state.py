"""Return the state of an entity."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import GetEntityState, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._entities import state_of, unknown
from hmrsim.services._results import OK

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: GetEntityState.Request) -> GetEntityState.Response:
    entity = simulator.roster.find(request.entity)
    if entity is None:
        return GetEntityState.Response(result=unknown(simulator, request.entity))
    return GetEntityState.Response(result=OK, state=state_of(simulator, entity))


SERVICE = Service(
    name="get_entity_state",
    request=GetEntityState.Request,
    response=GetEntityState.Response,
    serve=_serve,
    features=(SimulatorFeatures.ENTITY_STATE_GETTING,),
    example={"entity": "tester"},
)
