"""Inject a fault, now or later."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import dotted, shown
from hmrsim.interfaces.hmrsim_msgs import InjectFault
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import Service
from hmrsim.services._results import OK, failed
from hmrsim.world_checks.faults import read_fault

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding
    from hmrsim.simulation.simulator import Simulator


def _serve(simulator: Simulator, request: InjectFault.Request) -> InjectFault.Response:
    values = _settings_of(request)
    if values is None:
        why = f"settings: expected the text of a JSON object, got {shown(request.settings)}"
        return InjectFault.Response(result=failed(why))
    found = read_fault(request.type, values)
    name = found if isinstance(found, list) else simulator.fault_injector.inject(*found)
    if isinstance(name, str):
        return InjectFault.Response(result=OK, name=name)
    return InjectFault.Response(result=_wrong(name))


def _settings_of(request: InjectFault.Request) -> dict[str, Any] | None:
    """Return the keys of a request as in a world file; None if *settings* can't be read."""
    default = InjectFault.Request()
    fields = {key: value for key, value in request if value != getattr(default, key)}
    fields.pop("type", None)
    text = fields.pop("settings", "{}")
    try:
        further = json.loads(text)
    except (ValueError, RecursionError):
        return None
    return {**fields, **further} if isinstance(further, dict) else None


def _wrong(found: list[Finding]) -> Result:
    known = any(finding.message.startswith("no ") for finding in found)
    code = Result.RESULT_NOT_FOUND if known else Result.RESULT_OPERATION_FAILED
    texts = (f"{dotted(finding.path)}: {finding.message}" if finding.path else finding.message for finding in found)
    return failed("; ".join(texts), code)


SERVICE = Service(
    name="inject_fault",
    request=InjectFault.Request,
    response=InjectFault.Response,
    serve=_serve,
    changes_world=True,
    example={"type": "lane_closed", "lane": ["here", "there"], "duration": 5.0},
)
