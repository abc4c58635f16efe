"""Play, pause or stop the simulation."""

from __future__ import annotations

from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.simulation_interfaces import Result, SetSimulationState, SimulationState, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._results import OK, failed
from hmrsim.simulation.reset import set_state

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_VERBS: Final = MappingProxyType(
    {
        SimulationState.STATE_STOPPED: "stopped",
        SimulationState.STATE_PLAYING: "set to play",
        SimulationState.STATE_PAUSED: "paused",
    }
)


def _set(simulator: Simulator, state: int) -> Result:
    if state not in _VERBS:
        wanted = ", ".join(f"{number} ({verb})" for number, verb in _VERBS.items())
        why = f"state {state} can't be set; there are: {wanted}. The program itself ends with its process"
        return failed(why, Result.RESULT_FEATURE_UNSUPPORTED)
    if state == simulator.gate.state and not simulator.gate.stepping:
        why = f"the simulation is {_VERBS[state]} already"
        return failed(why, SetSimulationState.Response.ALREADY_IN_TARGET_STATE)
    set_state(simulator, state, f"the simulation was {_VERBS[state]}")
    return OK


SERVICE = Service(
    name="set_simulation_state",
    request=SetSimulationState.Request,
    response=SetSimulationState.Response,
    serve=lambda simulator, request: SetSimulationState.Response(result=_set(simulator, request.state.state)),
    changes_world=True,
    features=(SimulatorFeatures.SIMULATION_STATE_SETTING, SimulatorFeatures.SIMULATION_STATE_PAUSE),
    example={"state": {"state": SimulationState.STATE_PAUSED}},
)
