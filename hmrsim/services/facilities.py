"""Services that operate doors and lifts."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead
from hmrsim.facilities.doors import ORDERS, Door
from hmrsim.facilities.lifts import Lift
from hmrsim.interfaces.hmrsim_msgs import CallLift, SetDoorState
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import OK, Service, failed

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _set_door_state(simulator: Simulator, name: str, state: str) -> Result:
    doors = {other: door for other, door in simulator.roster.fixtures.items() if isinstance(door, Door)}
    if name not in doors:
        return failed(f"no door {name!r}{instead(name, doors)}", Result.RESULT_NOT_FOUND)
    if state not in ORDERS:
        return failed(f"no door state {state!r}{instead(state, ORDERS)}")
    why_not = doors[name].set(state)
    return failed(why_not, Result.RESULT_INCORRECT_STATE) if why_not else OK


def _call_lift(simulator: Simulator, name: str, stop: str) -> Result:
    lifts = {other: lift for other, lift in simulator.roster.fixtures.items() if isinstance(lift, Lift)}
    if name not in lifts:
        return failed(f"no lift {name!r}{instead(name, lifts)}", Result.RESULT_NOT_FOUND)
    lift = lifts[name]
    if stop not in lift.stops:
        return failed(f"{name!r} has no stop {stop!r}{instead(stop, lift.stops)}", Result.RESULT_NOT_FOUND)
    lift.call(stop)
    return OK


SERVICES = (
    Service(
        name="set_door_state",
        request=SetDoorState.Request,
        response=SetDoorState.Response,
        serve=lambda simulator, request: SetDoorState.Response(
            result=_set_door_state(simulator, request.name, request.state)
        ),
        changes_world=True,
        example={"name": "gate", "state": "open"},
    ),
    Service(
        name="call_lift",
        request=CallLift.Request,
        response=CallLift.Response,
        serve=lambda simulator, request: CallLift.Response(result=_call_lift(simulator, request.name, request.stop)),
        changes_world=True,
        example={"name": "lift", "stop": "upstairs"},
    ),
)
