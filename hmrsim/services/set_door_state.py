"""Open a door, close or lock it."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead
from hmrsim.facilities.doors import ORDERS, Door
from hmrsim.interfaces.hmrsim_msgs import SetDoorState
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import Service
from hmrsim.services._results import OK, failed

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _set(simulator: Simulator, name: str, state: str) -> Result:
    doors = {other: door for other, door in simulator.roster.fixtures.items() if isinstance(door, Door)}
    if name not in doors:
        return failed(f"no door {name!r}{instead(name, doors)}", Result.RESULT_NOT_FOUND)
    if state not in ORDERS:
        return failed(f"no state {state!r} of a door{instead(state, ORDERS)}")
    why_not = doors[name].set(state)
    return failed(why_not, Result.RESULT_INCORRECT_STATE) if why_not else OK


SERVICE = Service(
    name="set_door_state",
    request=SetDoorState.Request,
    response=SetDoorState.Response,
    serve=lambda simulator, request: SetDoorState.Response(result=_set(simulator, request.name, request.state)),
    changes_world=True,
    example={"name": "gate", "state": "open"},
)
