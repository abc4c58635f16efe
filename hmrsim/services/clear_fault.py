"""Clear faults that are active, and cancel those that are scheduled."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.diagnostics import instead
from hmrsim.faults import registry
from hmrsim.interfaces.hmrsim_msgs import ClearFault
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import Service
from hmrsim.services._results import OK, failed

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: ClearFault.Request) -> ClearFault.Response:
    known, name, kind = simulator.fault_injector.known, request.name, request.type
    if name and name not in known:
        why = f"name: no fault {name!r} goes on or is to come{instead(name, known)}"
        return ClearFault.Response(result=failed(why, Result.RESULT_NOT_FOUND))
    if kind and kind not in registry():
        why = f"type: no fault type {kind!r}{instead(kind, registry())}"
        return ClearFault.Response(result=failed(why, Result.RESULT_NOT_FOUND))
    names = sorted(each.name for each in known.values() if name in ("", each.name) and kind in ("", each.fault.name))
    for each in names:
        simulator.fault_injector.clear(each)
    return ClearFault.Response(result=OK, names=names)


SERVICE = Service(
    name="clear_fault",
    request=ClearFault.Request,
    response=ClearFault.Response,
    serve=_serve,
    changes_world=True,
    example={"type": "breakdown"},
)
