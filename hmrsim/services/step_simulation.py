"""Advance a paused simulation by a number of steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from hmrsim.interfaces.quantities import SECONDS
from hmrsim.interfaces.simulation_interfaces import SimulatorFeatures, StepSimulation
from hmrsim.services import Service
from hmrsim.services._results import OK, failed, of_steps

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_Response = StepSimulation.Response


def _serve(
    simulator: Simulator, request: StepSimulation.Request
) -> StepSimulation.Response | Callable[[Callable[[StepSimulation.Response], None]], None]:
    gate = simulator.gate
    why = gate.why_no_steps()
    if why is not None:
        # The service's own definition wants this code of an unpaused simulation, not INCORRECT_STATE.
        return _Response(result=failed(why))
    if not request.steps:
        return _Response(result=OK)
    if wrong := SECONDS.flaw(request.steps * gate.step_size):
        return _Response(result=failed(f"steps: {request.steps} of {gate.step_size:g} s: {wrong}"))
    return lambda answer: gate.make_steps(request.steps, lambda why_not: answer(_Response(result=of_steps(why_not))))


def _recorded(
    simulator: Simulator, request: StepSimulation.Request
) -> StepSimulation.Request | StepSimulation.Response:
    """Answer at once that no step can be made, where this does not depend on the world."""
    why = simulator.gate.hindrance()
    return _Response(result=failed(why)) if why and request.steps else request


SERVICE = Service(
    name="step_simulation",
    request=StepSimulation.Request,
    response=StepSimulation.Response,
    serve=_serve,
    changes_world=True,
    recorded=_recorded,
    features=(
        SimulatorFeatures.STEP_SIMULATION_SINGLE,
        SimulatorFeatures.STEP_SIMULATION_MULTIPLE,
        SimulatorFeatures.STEP_SIMULATION_ACTION,
    ),
)
