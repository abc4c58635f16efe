"""Call a lift to a stop."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead
from hmrsim.facilities.lifts import Lift
from hmrsim.interfaces.hmrsim_msgs import CallLift
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import Service
from hmrsim.services._results import OK, failed

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _call(simulator: Simulator, name: str, stop: str) -> Result:
    lifts = {other: lift for other, lift in simulator.roster.fixtures.items() if isinstance(lift, Lift)}
    if name not in lifts:
        return failed(f"no lift {name!r}{instead(name, lifts)}", Result.RESULT_NOT_FOUND)
    lift = lifts[name]
    if stop not in lift.stops:
        return failed(f"{name!r} has no stop {stop!r}{instead(stop, lift.stops)}", Result.RESULT_NOT_FOUND)
    lift.call(stop)
    return OK


SERVICE = Service(
    name="call_lift",
    request=CallLift.Request,
    response=CallLift.Response,
    serve=lambda simulator, request: CallLift.Response(result=_call(simulator, request.name, request.stop)),
    changes_world=True,
    example={"name": "lift", "stop": "upstairs"},
)
