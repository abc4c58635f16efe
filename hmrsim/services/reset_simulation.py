"""Reset time, the state of all entities, and the spawned entities, or some of these."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.interfaces.simulation_interfaces import ResetSimulation, Result, SimulatorFeatures
from hmrsim.services import Service
from hmrsim.services._results import OK, failed
from hmrsim.simulation.reset import reset

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_Scopes = ResetSimulation.Request
_KNOWN = (_Scopes.SCOPE_TIME, _Scopes.SCOPE_STATE, _Scopes.SCOPE_SPAWNED)


def _serve(simulator: Simulator, request: ResetSimulation.Request) -> ResetSimulation.Response:
    scope = request.scope
    if scope not in (_Scopes.SCOPE_ALL, scope & sum(_KNOWN)):
        why = f"scope {scope} has unknown bits; expected a sum of {', '.join(map(str, _KNOWN))}, or {_Scopes.SCOPE_ALL}"
        return ResetSimulation.Response(result=failed(why, Result.RESULT_FEATURE_UNSUPPORTED))
    reset(simulator, scope)
    return ResetSimulation.Response(result=OK)


SERVICE = Service(
    name="reset_simulation",
    request=ResetSimulation.Request,
    response=ResetSimulation.Response,
    serve=_serve,
    changes_world=True,
    features=(
        SimulatorFeatures.SIMULATION_RESET,
        SimulatorFeatures.SIMULATION_RESET_TIME,
        SimulatorFeatures.SIMULATION_RESET_STATE,
        SimulatorFeatures.SIMULATION_RESET_SPAWNED,
    ),
)
