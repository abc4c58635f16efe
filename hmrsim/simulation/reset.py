"""Reset of a simulation, in whole or in part, and replacement of its world.

The simulator remains the same object: no object that others hold is replaced, results are kept, and subscriptions
continue. Goals come first: each active goal that has to end is aborted with the reason.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

from hmrsim.engine.internal_errors import BUGS
from hmrsim.events.simulation import SimulationReset, SimulationStateChanged, WorldLoaded
from hmrsim.interfaces.simulation_interfaces import ResetSimulation, SimulationState
from hmrsim.protocol.goal import WORLD, Cause
from hmrsim.protocol.outputs import Restart, RosterChanged

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator
    from hmrsim.world.model import World

_RESET: Final = "the simulation was reset"
_TIME, _STATE, _SPAWNED, _ALL = (
    ResetSimulation.Request.SCOPE_TIME,
    ResetSimulation.Request.SCOPE_STATE,
    ResetSimulation.Request.SCOPE_SPAWNED,
    ResetSimulation.Request.SCOPE_ALL,
)


def reset(simulator: Simulator, scope: int = _ALL, *, stops: bool = False) -> None:
    """Reset the scopes of ResetSimulation that are given; *stops* says that it is because the simulation is stopped.

    Without STATE robots and items stay where they are, and scripts fail by their aborted goals.
    """
    scope = scope or _ALL
    if scope & (_STATE | _TIME):
        _end_all(simulator, _RESET, scripts=bool(scope & _STATE))
    if scope & _SPAWNED:
        for name in sorted(simulator.roster.spawned):
            if not simulator.demand.has(name):
                simulator.roster.delete(name, _RESET)
    if scope & _STATE:
        simulator.roster.restore()
    if scope & _TIME:
        whole = Restart.STOPPED if stops else Restart.RESET
        _restart_time(simulator, whole if scope & _STATE else Restart.TIME_RESET)
    if scope & (_STATE | _TIME):
        simulator.begin_chance()
    if scope & _STATE:
        simulator.begin_scripts()
    simulator.publisher.publish(lambda: SimulationReset(scope))


def load(simulator: Simulator, world: World) -> None:
    """Replace the world by another, whose names must have been checked; it is stopped then, at time 0."""
    before = simulator.world
    _end_all(simulator, "another world was loaded", scripts=True)
    try:
        simulator.replace_world(world)
    except BUGS:
        # Of a plug-in, such as a traffic policy: the world before is there again, as at its start.
        simulator.replace_world(before)
        _begin(simulator, None)
        raise
    _begin(simulator, world)


def _begin(simulator: Simulator, loaded: World | None) -> None:
    """Reset a simulation to its start after its world was replaced by another or by itself."""
    simulator.gate.set(SimulationState.STATE_STOPPED, "")
    _restart_time(simulator, Restart.WORLD_LOADED, loaded)
    world = simulator.world
    simulator.begin_chance()
    simulator.begin_scripts()
    simulator.publisher.publish(lambda: WorldLoaded(world.name))
    simulator.emit(RosterChanged())


def set_state(simulator: Simulator, state: int, why: str) -> None:
    """Change the state of the run, and end active steps with *why* as the reason; stopping also resets."""
    if state == SimulationState.STATE_STOPPED:
        reset(simulator, stops=True)
    simulator.roster.abort(why, Cause.RESET, WORLD)
    simulator.gate.set(state, why)
    simulator.publisher.publish(lambda: SimulationStateChanged(state))


def _end_all(simulator: Simulator, why: str, *, scripts: bool) -> None:
    """Abort all goals, and end the steps that are being made, and all faults; if asked the scripts before them."""
    if scripts:
        simulator.scripts.end()
    simulator.gate.halt(why)
    simulator.roster.abort(why, Cause.RESET)
    simulator.fault_injector.end()
    simulator.demand.end()
    for _, robot in sorted(simulator.robots.items()):
        # One that makes room for another, or lingers, has no goal.
        robot.halt()
        robot.stop_lingering()


def _restart_time(simulator: Simulator, cause: Restart, loaded: World | None = None) -> None:
    accounts = [robot.energy for _, robot in sorted(simulator.robots.items()) if robot.energy]
    for account in accounts:
        account.stop()
    simulator.restart_time(cause, loaded)
    for account in accounts:
        account.go_on()
    for fixture in simulator.roster.fixtures.values():
        fixture.settle()
    simulator.roster.admission.reset()
    simulator.gate.shut()
    simulator.telemetry.refresh(0.0)
