"""Return the state of the simulation."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import GetSimulationState, SimulationState, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._results import OK

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, _request: GetSimulationState.Request) -> GetSimulationState.Response:
    return GetSimulationState.Response(state=SimulationState(state=simulator.gate.state), result=OK)


SERVICE = Service(
    name="get_simulation_state",
    request=GetSimulationState.Request,
    response=GetSimulationState.Response,
    serve=_serve,
    features=(SimulatorFeatures.SIMULATION_STATE_GETTING,),
)
