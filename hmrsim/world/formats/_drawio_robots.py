"""Robots of draw.io pages: their components, scripts and paths.

Components are attributes ``component_<Class>="[arguments]"``, as in the original simulator.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import shown
from hmrsim.world.formats._drawio_cells import BadCell, read_number

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.formats._drawio_cells import Cell
    from hmrsim.world.formats._drawio_drawing import Drawing

_CLAW, _BATTERY, _SCRIPT = "component_Claw", "component_Battery", "component_Script"

_OLD_BATTERY = "battery"

_CLAW_ARGUMENTS = ("reach", "max_weight")

_STATES = ("default", "still", "moving")
"""The states that have a drain in old maps."""


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
"""The readers of our components' settings from the attributes of a robot, which raise BadCell."""


def script(attributes: Mapping[str, str]) -> list[str]:
    """Return the orders of a robot's script: ``[["Go x", …], n]``, or an empty list without a script.

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
    """Yield a message for each unknown component, which is ignored."""
    for key in attributes:
        if key.startswith("component_") and key not in {_CLAW, _BATTERY, _SCRIPT}:
            yield f"{key} is not known here and left out"


_FRAMES = 60.0
"""Frames per second of the original; old maps have speeds in px per frame."""


def robot(drawing: Drawing, cell: Cell) -> None:
    """Read a robot and report all of its errors.

    Raises:
        BadCell: Its name is taken.
    """
    old = drawing.name(cell, "name", "robot")
    name = drawing.options.rename.get(old, old)
    drawing.renamable.append(old)
    drawing.robot_of[cell.id] = name
    fields: dict[str, Any] = {
        "at": list(cell.box.center),
        "base": drawing.attempt(cell, partial(_base, cell)) or {},
        "components": {},
        "script": drawing.attempt(cell, partial(script, cell.attributes)) or [],
    }
    for component, read in READERS.items():
        settings = drawing.attempt(cell, partial(read, cell.attributes))
        if settings is not None:
            fields["components"][component] = settings
    for warning in odd(cell.attributes):
        drawing.warn(cell, warning)
    if cell.attributes.get("movable", "true") != "true":
        movable = cell.attributes["movable"]
        drawing.warn(cell, f"movable is {shown(movable)}; robots can always move here", movable)
    if name != old and name in drawing.robots:
        raise BadCell(f"can't be renamed to {name!r}, which another robot is called", name)
    drawing.keep(cell, "robots", name, fields)


def _base(cell: Cell) -> dict[str, float]:
    base: dict[str, float] = {}
    if cell.box.width and cell.box.height:
        base["radius"] = max(cell.box.width, cell.box.height) / 2
    if "speed" in cell.attributes:
        text = cell.attributes["speed"]
        speed = read_number(text, "speed")
        if speed <= 0:
            raise BadCell(f"speed is {shown(text)}; expected a number above 0, in px a frame", text)
        base["speed"] = speed * _FRAMES
    return base


def way(drawing: Drawing, cell: Cell) -> None:
    """Read a path that the robot at its start follows by itself.

    Raises:
        BadCell: There is no robot, or a number is invalid.
    """
    source = drawing.end(cell, "source")
    if source is None or source.kind != "robot":
        what = "no source" if source is None else f"the source {shown(source.id)}, which is not a robot"
        raise BadCell(f"has {what}; draw it from the robot that is to follow it", source and source.id)
    target = drawing.end(cell, "target")
    points = [*cell.points(), *([target.box.center] if target else ())]
    if not points:
        drawing.warn(cell, "has no points, so there is nothing to follow")
    elif source.id in drawing.robot_of:
        drawing.ways[drawing.robot_of[source.id]].append((cell, points))


def follow_ways(drawing: Drawing) -> None:
    """Add the paths that robots follow before the other orders of their scripts."""
    for name, ways in drawing.ways.items():
        if name in drawing.robots:
            fields = drawing.robots[name]
            fields["script"] = [*(_order(points) for _, points in ways), *fields["script"]]
            drawing.lines |= {("robots", name, "script", i): cell.line for i, (cell, _) in enumerate(ways)}


def _order(points: list[Point]) -> str:
    """Return the order to follow these points, with the fewest digits that keep them exact."""
    return f"Follow {' '.join(repr(value).removesuffix('.0') for point in points for value in point)}"
