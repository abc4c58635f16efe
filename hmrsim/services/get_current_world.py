"""Return the current world."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import GetCurrentWorld, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._results import OK
from hmrsim.services._worlds import resource_of

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, _request: GetCurrentWorld.Request) -> GetCurrentWorld.Response:
    return GetCurrentWorld.Response(result=OK, world=resource_of(simulator.world))


SERVICE = Service(
    name="get_current_world",
    request=GetCurrentWorld.Request,
    response=GetCurrentWorld.Response,
    serve=_serve,
    features=(SimulatorFeatures.WORLD_INFO_GETTING,),
)
