"""Services that operate doors and lifts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead
from hmrsim.facilities.doors import ORDERS, Door
from hmrsim.facilities.lifts import Lift
from hmrsim.interfaces.hmrsim_msgs import CallLift, SetDoorState
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import RequestFailed, Service

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _set_door_state(simulator: Simulator, request: SetDoorState.Request) -> None:
    name, state = request.name, request.state
    doors = {other: door for other, door in simulator.roster.fixtures.items() if isinstance(door, Door)}
    if name not in doors:
        raise RequestFailed(f"no door {name!r}{instead(name, doors)}", Result.RESULT_NOT_FOUND)
    if state not in ORDERS:
        raise RequestFailed(f"no door state {state!r}{instead(state, ORDERS)}")
    if why_not := doors[name].set(state):
        raise RequestFailed(why_not, Result.RESULT_INCORRECT_STATE)


def _call_lift(simulator: Simulator, request: CallLift.Request) -> None:
    name, stop = request.name, request.stop
    lifts = {other: lift for other, lift in simulator.roster.fixtures.items() if isinstance(lift, Lift)}
    if name not in lifts:
        raise RequestFailed(f"no lift {name!r}{instead(name, lifts)}", Result.RESULT_NOT_FOUND)
    lift = lifts[name]
    if stop not in lift.stops:
        raise RequestFailed(f"{name!r} has no stop {stop!r}{instead(stop, lift.stops)}", Result.RESULT_NOT_FOUND)
    lift.call(stop)


SERVICES = (
    Service(SetDoorState, _set_door_state, changes_world=True, example={"name": "gate", "state": "open"}),
    Service(CallLift, _call_lift, changes_world=True, example={"name": "lift", "stop": "upstairs"}),
)
