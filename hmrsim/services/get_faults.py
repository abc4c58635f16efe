"""Return the active and the scheduled faults."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.engine.sim_time import nanoseconds
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.hmrsim_msgs import Fault, GetFaults
from hmrsim.services import Service
from hmrsim.services._results import OK

if TYPE_CHECKING:
    from hmrsim.simulation.fault_injector import InjectedFault
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, _request: GetFaults.Request) -> GetFaults.Response:
    faults = [_message_of(injected) for _, injected in sorted(simulator.fault_injector.known.items())]
    return GetFaults.Response(result=OK, faults=faults)


def _message_of(injected: InjectedFault) -> Fault:
    active = injected.end is not None
    return Fault(
        name=injected.name,
        type=injected.fault.name,
        active=active,
        since=Time.from_nanoseconds(nanoseconds(injected.since) if active else 0),
        settings=injected.settings.model_dump_json(exclude_none=True, exclude={"name"}),
    )


SERVICE = Service(name="get_faults", request=GetFaults.Request, response=GetFaults.Response, serve=_serve)
