"""Return the states of entities."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import GetEntitiesStates, Result, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._entities import matching, state_of
from hmrsim.services._results import OK

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: GetEntitiesStates.Request) -> GetEntitiesStates.Response:
    found = matching(simulator, request.filters)
    if isinstance(found, Result):
        return GetEntitiesStates.Response(result=found)
    return GetEntitiesStates.Response(
        result=OK,
        entities=[entity.name for entity in found],
        states=[state_of(simulator, entity) for entity in found],
    )


SERVICE = Service(
    name="get_entities_states",
    request=GetEntitiesStates.Request,
    response=GetEntitiesStates.Response,
    serve=_serve,
    features=(SimulatorFeatures.ENTITY_STATE_GETTING,),
)
