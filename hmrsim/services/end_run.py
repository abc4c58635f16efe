"""Report how a run has ended."""

from __future__ import annotations

import json
import re
from typing import TYPE_CHECKING, Any, Final

from hmrsim.diagnostics import shown
from hmrsim.events.simulation import RunReported
from hmrsim.interfaces.hmrsim_msgs import EndRun
from hmrsim.services import Service
from hmrsim.services._results import OK, failed

if TYPE_CHECKING:
    from hmrsim.simulation.simulator import Simulator

_LABEL: Final = re.compile(r"[A-Za-z_][A-Za-z0-9_]{0,99}")
_MAX_VALUES: Final = 100


def _serve(simulator: Simulator, request: EndRun.Request) -> EndRun.Response:
    if not _LABEL.fullmatch(request.label):
        why = f"label: expected a word of letters, digits and _, got {shown(request.label)}"
        return EndRun.Response(result=failed(why))
    values = _values_of(request.values)
    if values is None:
        why = (
            "values: expected the text of a JSON object with at most "
            f"{_MAX_VALUES} numbers, texts, true and false, got {shown(request.values)}"
        )
        return EndRun.Response(result=failed(why))
    simulator.publisher.publish(lambda: RunReported(request.label, values))
    return EndRun.Response(result=OK)


def _values_of(text: str) -> dict[str, Any] | None:
    """Return the values of a report; None if they can't be read."""
    try:
        values = json.loads(text or "{}", parse_constant=lambda _text: {})
    except (ValueError, RecursionError):
        return None
    if not isinstance(values, dict) or len(values) > _MAX_VALUES:
        return None
    plain = all(_LABEL.fullmatch(name) and isinstance(each, (int, float, str)) for name, each in values.items())
    return values if plain else None


SERVICE = Service(
    name="end_run",
    request=EndRun.Request,
    response=EndRun.Response,
    serve=_serve,
    changes_world=True,
    example={"label": "done", "values": '{"rounds": 3}'},
)
