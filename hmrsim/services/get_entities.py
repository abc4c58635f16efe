"""Return the entities of the world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import GetEntities, Result, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._entities import matching
from hmrsim.services._results import OK

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: GetEntities.Request) -> GetEntities.Response:
    found = matching(simulator, request.filters)
    if isinstance(found, Result):
        return GetEntities.Response(result=found)
    return GetEntities.Response(result=OK, entities=[entity.name for entity in found])


SERVICE = Service(
    name="get_entities",
    request=GetEntities.Request,
    response=GetEntities.Response,
    serve=_serve,
    features=(SimulatorFeatures.ENTITY_TAGS, SimulatorFeatures.ENTITY_CATEGORIES, SimulatorFeatures.ENTITY_BOUNDS_BOX),
    example={"filters": {"filter": "^test"}},
)
