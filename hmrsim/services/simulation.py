"""Services that query, play, pause, step and reset the simulation, and report the outcome of a run."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.diagnostics import shown
from hmrsim.events.simulation import RunReported
from hmrsim.interfaces.hmrsim_msgs import EndRun
from hmrsim.interfaces.quantities import SECONDS
from hmrsim.interfaces.simulation_interfaces import (
    GetSimulationState,
    GetSimulatorFeatures,
    ResetSimulation,
    Result,
    SetSimulationState,
    SimulationState,
    SimulatorFeatures,
    StepSimulation,
)
from hmrsim.services import OK, Answer, RequestFailed, Service, failed, registry
from hmrsim.simulation.reset import reset, set_state

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_ABOUT: Final = (
    "hmrsim: mission-level simulation of robots and items in a plane; get_spawnables lists what can be spawned"
)
_VERBS: Final = MappingProxyType(
    {
        SimulationState.STATE_STOPPED: "stopped",
        SimulationState.STATE_PLAYING: "set to play",
        SimulationState.STATE_PAUSED: "paused",
    }
)
_Scopes = ResetSimulation.Request
_SCOPES: Final = (_Scopes.SCOPE_TIME, _Scopes.SCOPE_STATE, _Scopes.SCOPE_SPAWNED)
_LABEL: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,99}")
_MAX_VALUES: Final = 100


def _get_simulator_features(
    _simulator: Simulator, _request: GetSimulatorFeatures.Request
) -> GetSimulatorFeatures.Response:
    features = sorted({feature for service in registry().values() for feature in service.features})
    return GetSimulatorFeatures.Response(features=SimulatorFeatures(features=features, custom_info=_ABOUT))


def _get_simulation_state(simulator: Simulator, _request: GetSimulationState.Request) -> GetSimulationState.Response:
    return GetSimulationState.Response(state=SimulationState(state=simulator.gate.state), result=OK)


def _set_simulation_state(simulator: Simulator, request: SetSimulationState.Request) -> None:
    state = request.state.state
    if state not in _VERBS:
        states = ", ".join(f"{number} ({verb})" for number, verb in _VERBS.items())
        why = f"state {state} can't be set; there are: {states}. The program itself ends with its process"
        raise RequestFailed(why, Result.RESULT_FEATURE_UNSUPPORTED)
    if state == simulator.gate.state and not simulator.gate.stepping:
        why = f"the simulation is {_VERBS[state]} already"
        raise RequestFailed(why, SetSimulationState.Response.ALREADY_IN_TARGET_STATE)
    set_state(simulator, state, f"the simulation was {_VERBS[state]}")


def _step_simulation(simulator: Simulator, request: StepSimulation.Request) -> Callable[[Answer], None] | None:
    gate = simulator.gate
    why = gate.why_no_steps()
    if why is not None:
        # The ROS definition of the service requires this code if the simulation isn't paused, not INCORRECT_STATE.
        raise RequestFailed(why)
    if not request.steps:
        return None
    if wrong := SECONDS.flaw(request.steps * gate.step_size):
        raise RequestFailed(f"steps: {request.steps} of {gate.step_size:g} s: {wrong}")

    def respond(why_not: str, answer: Answer) -> None:
        answer(StepSimulation.Response(result=failed(why_not) if why_not else OK))

    return lambda answer: gate.make_steps(request.steps, partial(respond, answer=answer))


def _resolve_steps(simulator: Simulator, request: StepSimulation.Request) -> StepSimulation.Request:
    """Return the request, unless it fails in any world."""
    if request.steps and (why := simulator.gate.hindrance()):
        raise RequestFailed(why)
    return request


def _reset_simulation(simulator: Simulator, request: ResetSimulation.Request) -> None:
    scope = request.scope
    if scope not in (_Scopes.SCOPE_ALL, scope & sum(_SCOPES)):
        why = (
            f"scope {scope} has unknown bits; expected a sum of {', '.join(map(str, _SCOPES))}, or {_Scopes.SCOPE_ALL}"
        )
        raise RequestFailed(why, Result.RESULT_FEATURE_UNSUPPORTED)
    reset(simulator, scope)


def _end_run(simulator: Simulator, request: EndRun.Request) -> None:
    if not _LABEL.fullmatch(request.label):
        raise RequestFailed(f"label: expected a word of letters, digits and _, got {shown(request.label)}")
    values = _values_of(request.values)
    if values is None:
        raise RequestFailed(
            "values: expected the text of a JSON object with at most "
            f"{_MAX_VALUES} numbers, texts, true and false, got {shown(request.values)}"
        )
    simulator.publisher.announce(RunReported(request.label, values))


def _values_of(text: str) -> dict[str, Any] | None:
    """Return the values of a report, or None if they are invalid."""
    try:
        values = json.loads(text or "{}", parse_constant=lambda _text: {})
    except (ValueError, RecursionError):
        return None
    if not isinstance(values, dict) or len(values) > _MAX_VALUES:
        return None
    valid = all(_LABEL.fullmatch(name) and isinstance(value, (int, float, str)) for name, value in values.items())
    return values if valid else None


SERVICES = (
    Service(GetSimulatorFeatures, _get_simulator_features),
    Service(GetSimulationState, _get_simulation_state, features=(SimulatorFeatures.SIMULATION_STATE_GETTING,)),
    Service(
        SetSimulationState,
        _set_simulation_state,
        changes_world=True,
        features=(SimulatorFeatures.SIMULATION_STATE_SETTING, SimulatorFeatures.SIMULATION_STATE_PAUSE),
        example={"state": {"state": SimulationState.STATE_PAUSED}},
    ),
    Service(
        StepSimulation,
        _step_simulation,
        changes_world=True,
        resolve=_resolve_steps,
        features=(
            SimulatorFeatures.STEP_SIMULATION_SINGLE,
            SimulatorFeatures.STEP_SIMULATION_MULTIPLE,
            SimulatorFeatures.STEP_SIMULATION_ACTION,
        ),
    ),
    Service(
        ResetSimulation,
        _reset_simulation,
        changes_world=True,
        features=(
            SimulatorFeatures.SIMULATION_RESET,
            SimulatorFeatures.SIMULATION_RESET_TIME,
            SimulatorFeatures.SIMULATION_RESET_STATE,
            SimulatorFeatures.SIMULATION_RESET_SPAWNED,
        ),
    ),
    Service(EndRun, _end_run, changes_world=True, example={"label": "done", "values": '{"rounds": 3}'}),
)
