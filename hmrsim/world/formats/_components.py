"""The components of the original's robots, which draw.io files write as ``component_<Class>="[arguments]"``."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from hmrsim.diagnostics import shown
from hmrsim.world.formats._cells import BadCell

_CLAW, _BATTERY, _SCRIPT = "component_Claw", "component_Battery", "component_Script"

_OLD_BATTERY = "battery"

_CLAW_ARGUMENTS = ("reach", "max_weight")

_STATES = ("default", "still", "moving")
"""What old maps tell the drain of."""


def _list(attributes: Mapping[str, str], key: str, example: str) -> list[Any]:
    value = _json(attributes, key, example)
    if not isinstance(value, list):
        raise BadCell(f"{key} is {shown(value)}; expected a JSON list such as {example}", value)
    return value


def _json(attributes: Mapping[str, str], key: str, example: str) -> object:
    text = attributes[key]
    try:
        return json.loads(text, parse_constant=_refuse)
    except (ValueError, RecursionError):
        raise BadCell(f"{key} is {shown(text)}; expected JSON such as {example}", text) from None


def _refuse(text: str) -> None:
    raise ValueError(text)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _claw(attributes: Mapping[str, str]) -> dict[str, Any] | None:
    if _CLAW not in attributes:
        return None
    values = _list(attributes, _CLAW, "[80, 1]")
    if len(values) > len(_CLAW_ARGUMENTS):
        names = ", ".join(_CLAW_ARGUMENTS)
        raise BadCell(f"{_CLAW} has {len(values)} arguments; expected at most {len(_CLAW_ARGUMENTS)}: {names}", values)
    return dict(zip(_CLAW_ARGUMENTS, values, strict=False))


def _battery(attributes: Mapping[str, str]) -> dict[str, Any] | None:
    """Return a battery: its capacity from the component, its charge and drain from the attribute of old maps."""
    if _BATTERY not in attributes and _OLD_BATTERY not in attributes:
        return None
    settings: dict[str, Any] = {}
    if _OLD_BATTERY in attributes:
        settings = _old_battery(_json(attributes, _OLD_BATTERY, '{"initialCharge": 5000}'))
    if _BATTERY in attributes:
        values = _list(attributes, _BATTERY, "[3600]")
        numbers = [value for value in values if _is_number(value)]
        if values and not numbers:
            raise BadCell(f"{_BATTERY} is {shown(values)}; expected its capacity, such as [3600]", values)
        settings |= {"capacity": numbers[0]} if numbers else {}
    return settings


def _old_battery(value: object) -> dict[str, Any]:
    table = value.get("lookupTable", {}) if isinstance(value, dict) else None
    if not isinstance(value, dict) or not isinstance(table, dict):
        expected = '{"initialCharge": 5000, "lookupTable": {"default": 1, "still": 0.5, "moving": 2}}'
        raise BadCell(f"{_OLD_BATTERY} is {shown(value)}; expected JSON such as {expected}", value)
    settings = dict.fromkeys(("capacity", "initial_charge"), value["initialCharge"]) if "initialCharge" in value else {}
    drain = {state: table[state] for state in _STATES if state in table}
    return {**settings, "drain": drain} if drain else settings


READERS: dict[str, Callable[[Mapping[str, str]], dict[str, Any] | None]] = {"claw": _claw, "battery": _battery}
"""What reads the settings of our components from the attributes of a robot; it raises BadCell."""


def script(attributes: Mapping[str, str]) -> list[str]:
    """Return the orders of a robot's script: ``[["Go x", …], n]``; none without one.

    Raises:
        BadCell: It is no such list.
    """
    if _SCRIPT not in attributes:
        return []
    values = _list(attributes, _SCRIPT, '[["Go place"], 0]')
    orders = values[0] if values else []
    if not isinstance(orders, list) or not all(isinstance(order, str) for order in orders):
        raise BadCell(f'{_SCRIPT} is {shown(values)}; expected [["Go place", …], 0]', values)
    if not all(_is_number(count) for count in values[1:]):
        raise BadCell(f"{_SCRIPT} has {shown(values[1:])} after its orders; expected a number", values[1:])
    return orders


def odd(attributes: Mapping[str, str]) -> Iterator[str]:
    """Yield the settings of a robot that are left out: unknown components."""
    for key in attributes:
        if key.startswith("component_") and key not in {_CLAW, _BATTERY, _SCRIPT}:
            yield f"{key} is not known here and left out"
