"""Delete an entity from the world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.facilities import Fixture
from hmrsim.interfaces.simulation_interfaces import DeleteEntity, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._entities import unknown
from hmrsim.services._results import OK, failed

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: DeleteEntity.Request) -> DeleteEntity.Response:
    entity = simulator.roster.find(request.entity)
    if entity is None:
        return DeleteEntity.Response(result=unknown(simulator, request.entity))
    if isinstance(entity, Fixture):
        return DeleteEntity.Response(result=failed(f"{entity.name!r} is a {entity.kind}, a part of the building"))
    simulator.roster.delete(request.entity)
    return DeleteEntity.Response(result=OK)


SERVICE = Service(
    name="delete_entity",
    request=DeleteEntity.Request,
    response=DeleteEntity.Response,
    serve=_serve,
    changes_world=True,
    features=(SimulatorFeatures.DELETING,),
    example={"entity": "parcel"},
)
