"""Services that inject, clear and list faults."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import dotted, instead, shown
from hmrsim.engine.sim_time import nanoseconds
from hmrsim.faults import registry
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.hmrsim_msgs import ClearFault, Fault, GetFaults, InjectFault
from hmrsim.interfaces.simulation_interfaces import Result
from hmrsim.services import OK, RequestFailed, Service
from hmrsim.world_checks.faults import read_fault

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding
    from hmrsim.simulation.fault_injector import InjectedFault
    from hmrsim.simulation.simulator import Simulator


def _inject_fault(simulator: Simulator, request: InjectFault.Request) -> InjectFault.Response:
    fault = read_fault(request.type, _settings_of(request))
    name = fault if isinstance(fault, list) else simulator.fault_injector.inject(*fault)
    if isinstance(name, str):
        return InjectFault.Response(result=OK, name=name)
    raise _invalid(name)


def _settings_of(request: InjectFault.Request) -> dict[str, Any]:
    """Return the keys of a request as in a world file.

    Raises:
        RequestFailed: The settings are invalid.
    """
    default = InjectFault.Request()
    fields = {key: value for key, value in request if value != getattr(default, key)}
    fields.pop("type", None)
    text = fields.pop("settings", "{}")
    try:
        further = json.loads(text)
    except (ValueError, RecursionError):
        further = None
    if not isinstance(further, dict):
        raise RequestFailed(f"settings: expected the text of a JSON object, got {shown(request.settings)}")
    return {**fields, **further}


def _invalid(findings: list[Finding]) -> RequestFailed:
    missing = any(finding.message.startswith("no ") for finding in findings)
    code = Result.RESULT_NOT_FOUND if missing else Result.RESULT_OPERATION_FAILED
    texts = (f"{dotted(finding.path)}: {finding.message}" if finding.path else finding.message for finding in findings)
    return RequestFailed("; ".join(texts), code)


def _clear_fault(simulator: Simulator, request: ClearFault.Request) -> ClearFault.Response:
    known, name, kind = simulator.fault_injector.known, request.name, request.type
    if name and name not in known:
        raise RequestFailed(
            f"name: no fault {name!r} goes on or is to come{instead(name, known)}", Result.RESULT_NOT_FOUND
        )
    if kind and kind not in registry():
        raise RequestFailed(f"type: no fault type {kind!r}{instead(kind, registry())}", Result.RESULT_NOT_FOUND)
    cleared = sorted(
        injected.name
        for injected in known.values()
        if name in ("", injected.name) and kind in ("", injected.fault.name)
    )
    for fault in cleared:
        simulator.fault_injector.clear(fault)
    return ClearFault.Response(result=OK, names=cleared)


def _get_faults(simulator: Simulator, _request: GetFaults.Request) -> GetFaults.Response:
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


SERVICES = (
    Service(
        InjectFault,
        _inject_fault,
        changes_world=True,
        example={"type": "lane_closed", "lane": ["here", "there"], "duration": 5.0},
    ),
    Service(ClearFault, _clear_fault, changes_world=True, example={"type": "breakdown"}),
    Service(GetFaults, _get_faults),
)
