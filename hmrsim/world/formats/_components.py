"""The components of the original's robots, which draw.io files write as ``component_<Class>="[arguments]"``."""

from __future__ import annotations

import json
from typing import Any

from hmrsim.world.finding import shown
from hmrsim.world.formats._mxgraph import BadCell

_ARGUMENTS = {"component_Claw": ("claw", ("reach", "max_weight"))}
"""The component of ours and the settings that the arguments are, in order."""

_SCRIPT = "component_Script"


def arguments(key: str, text: str) -> list[Any]:
    """Return the arguments that an attribute holds.

    Raises:
        BadCell: It is no JSON list.
    """
    try:
        value = json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise BadCell(f"{key} is {shown(text)}; expected a JSON list such as [80, 1]") from None
    if not isinstance(value, list):
        raise BadCell(f"{key} is {shown(value)}; expected a JSON list such as [80, 1]")
    return value


def _refuse(text: str) -> None:
    raise ValueError(text)


def component(key: str, text: str) -> tuple[str, dict[str, Any]] | None:
    """Return one of our components and its settings; None for a class that we don't know.

    Raises:
        BadCell: The arguments make no sense.
    """
    if key not in _ARGUMENTS:
        return None
    name, fields = _ARGUMENTS[key]
    values = arguments(key, text)
    if len(values) > len(fields):
        raise BadCell(f"{key} has {len(values)} arguments; expected at most {len(fields)}: {', '.join(fields)}")
    return name, dict(zip(fields, values, strict=False))


def script(attributes: dict[str, str]) -> list[str]:
    """Return the orders of a robot's script: ``[["Go x", …], n]``; none without one.

    Raises:
        BadCell: It is no such list.
    """
    if _SCRIPT not in attributes:
        return []
    values = arguments(_SCRIPT, attributes[_SCRIPT])
    orders = values[0] if values else []
    if not isinstance(orders, list) or not all(isinstance(order, str) for order in orders):
        raise BadCell(f'{_SCRIPT} is {shown(values)}; expected [["Go place", …], 0]')
    return orders


def others(attributes: dict[str, str]) -> list[str]:
    """Return the attributes that name a component which we don't know."""
    known = {*_ARGUMENTS, _SCRIPT}
    return [key for key in attributes if key.startswith("component_") and key not in known]


def known(attributes: dict[str, str]) -> dict[str, dict[str, Any]]:
    """Return our components with their settings.

    Raises:
        BadCell: The arguments of one make no sense.
    """
    found = (component(key, text) for key, text in attributes.items())
    return dict(part for part in found if part is not None)
