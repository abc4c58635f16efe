"""Return the spawnables."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import GetSpawnables, Result, SimulatorFeatures, Spawnable
from hmrsim.services import Service
from hmrsim.services._results import OK
from hmrsim.services._spawnables import kinds

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: GetSpawnables.Request) -> GetSpawnables.Response:
    found = [Spawnable(uri=kind.uri, description=kind.description) for kind in kinds(simulator.world)]
    result = OK
    if request.sources:
        why = f"unknown sources are left out: {', '.join(request.sources)}"
        result = Result(result=Result.RESULT_OK, error_message=why)
    return GetSpawnables.Response(result=result, spawnables=found)


SERVICE = Service(
    name="get_spawnables",
    request=GetSpawnables.Request,
    response=GetSpawnables.Response,
    serve=_serve,
    features=(SimulatorFeatures.SPAWNABLES,),
)
