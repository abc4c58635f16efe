"""The entities of draw.io pages: robots with components, scripts and paths, and obstacles, items and places.

A component of a robot is an attribute ``component_<Class>="[arguments]"``, as in the original simulator.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import shown
from hmrsim.world.formats._drawio_cells import BadCell, read_number, style_number, turn

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.formats._drawio_cells import Box, Cell
    from hmrsim.world.formats._drawio_drawing import Drawing


_CLAW, _BATTERY, _SCRIPT = "component_Claw", "component_Battery", "component_Script"

_OLD_BATTERY = "battery"

_CLAW_ARGUMENTS = ("reach", "max_weight")

_STATES = ("default", "still", "moving")
"""The states of a robot for which old maps give a drain."""


_FRAMES = 60.0
"""Frames per second of the original simulator, whose maps have speeds in px per frame."""


def read_robot(drawing: Drawing, cell: Cell) -> None:
    """Read a robot, and report all errors in it.

    Raises:
        BadCell: The name is taken.
    """
    old = drawing.name(cell, "name", "robot")
    name = drawing.options.rename.get(old, old)
    drawing.renamable.append(old)
    drawing.robot_of[cell.id] = name
    fields: dict[str, Any] = {
        "at": list(cell.box.center),
        "base": drawing.attempt(cell, partial(_base, cell)) or {},
        "components": {},
        "script": drawing.attempt(cell, partial(_script, cell.attributes)) or [],
    }
    for component, read in _READERS.items():
        settings = drawing.attempt(cell, partial(read, cell.attributes))
        if settings is not None:
            fields["components"][component] = settings
    for warning in _unknown_components(cell.attributes):
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


def _script(attributes: Mapping[str, str]) -> list[str]:
    """Return the orders of a robot's script ``[["Go x", …], n]``; an empty list if it has none.

    Raises:
        BadCell: The script has another form.
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


def _unknown_components(attributes: Mapping[str, str]) -> Iterator[str]:
    """Yield a warning for each unknown component, which is ignored."""
    for key in attributes:
        if key.startswith("component_") and key not in {_CLAW, _BATTERY, _SCRIPT}:
            yield f"{key} is not known here and left out"


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
    """Return the settings of a battery: the capacity from the component, the rest from the attribute of old maps."""
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


_READERS: dict[str, Callable[[Mapping[str, str]], dict[str, Any] | None]] = {"claw": _claw, "battery": _battery}
"""The functions that read the settings of a component from the attributes of a robot; they raise BadCell."""


def read_path(drawing: Drawing, cell: Cell) -> None:
    """Read a path that the robot at its start follows without a controller.

    Raises:
        BadCell: There is no robot at the start, or a number is invalid.
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


def add_paths_to_scripts(drawing: Drawing) -> None:
    """Insert the paths of robots before the other orders of their scripts."""
    for name, ways in drawing.ways.items():
        if name in drawing.robots:
            fields = drawing.robots[name]
            fields["script"] = [*(_order(points) for _, points in ways), *fields["script"]]
            drawing.lines |= {("robots", name, "script", i): cell.line for i, (cell, _) in enumerate(ways)}


def _order(points: list[Point]) -> str:
    """Return the order of a script to follow points, whose coordinates are exact."""
    return f"Follow {' '.join(repr(value).removesuffix('.0') for point in points for value in point)}"


Outline = tuple["Point", ...]

_THICKNESS = 10.0
"""The thickness of the walls of rooms and corners, in px."""

_ELLIPSE_CORNERS = 24

_SIDES = ("left", "top", "right", "bottom")
"""The sides in clockwise order."""

_BARS = {"wallU": _SIDES[:3], "wallCorner": _SIDES[:2], "room": _SIDES}
"""The walls of a shape that faces east."""

_DIRECTIONS = {"east": 0, "south": 1, "west": 2, "north": 3}
"""Quarter turns of a shape inside its box, clockwise."""

_FLIPS = {"flipH": {"left": "right", "right": "left"}, "flipV": {"top": "bottom", "bottom": "top"}}


def outlines(box: Box, style: dict[str, str]) -> list[Outline]:
    """Return the area of a shape as closed outlines, rotated like the shape.

    Raises:
        BadCell: A number of the style is invalid.
    """
    shape = _shape(style)
    if shape in _BARS:
        thick, drawn = thickness(style), _drawn(_BARS[shape], style)
        found = [_bar(box, side, thick) for side in _SIDES if side in drawn]
    elif "ellipse" in style or shape == "ellipse":
        found = [_ellipse(box)]
    else:
        found = [_rectangle(box.x, box.y, box.width, box.height)]
    return [tuple(turn(point, box) for point in outline) for outline in found]


def thickness(style: dict[str, str]) -> float:
    """Return the thickness of a shape's walls, or 0 if it covers its whole box.

    Raises:
        BadCell: The thickness is invalid.
    """
    if _shape(style) not in _BARS:
        return 0.0
    thick = style_number(style, "wallThickness", _THICKNESS)
    if thick <= 0:
        text = style["wallThickness"]
        raise BadCell(f"wallThickness is {shown(text)}; expected a number above 0, such as {_THICKNESS:g}", text)
    return thick


def _shape(style: dict[str, str]) -> str:
    return style.get("shape", "").removeprefix("mxgraph.floorplan.")


def _drawn(sides: tuple[str, ...], style: dict[str, str]) -> set[str]:
    """Return the sides of the box that have a wall; draw.io first rotates the shape, then flips it."""
    direction = style.get("direction") or "east"
    if direction not in _DIRECTIONS:
        raise BadCell(f"direction is {shown(direction)}; expected one of {', '.join(_DIRECTIONS)}", direction)
    quarters = _DIRECTIONS[direction]
    drawn = {_SIDES[(_SIDES.index(side) + quarters) % 4] for side in sides}
    for flag, other in _FLIPS.items():
        if style.get(flag) == "1":
            drawn = {other.get(side, side) for side in drawn}
    return drawn


def _rectangle(x: float, y: float, width: float, height: float) -> Outline:
    return ((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def _bar(box: Box, side: str, thick: float) -> Outline:
    """Return one wall inside a box, along one of its sides; at most as thick as the box."""
    thick_x, thick_y = min(thick, box.width), min(thick, box.height)
    if side == "left":
        return _rectangle(box.x, box.y, thick_x, box.height)
    if side == "right":
        return _rectangle(box.x + box.width - thick_x, box.y, thick_x, box.height)
    if side == "top":
        return _rectangle(box.x, box.y, box.width, thick_y)
    return _rectangle(box.x, box.y + box.height - thick_y, box.width, thick_y)


def _ellipse(box: Box) -> Outline:
    (x, y), a, b = box.middle, box.width / 2, box.height / 2
    angles = [math.tau * i / _ELLIPSE_CORNERS for i in range(_ELLIPSE_CORNERS)]
    return tuple((x + a * math.cos(angle), y + b * math.sin(angle)) for angle in angles)


_DECORATION = frozenset(("text", "edgeLabel", "group", "swimlane"))
"""Style words of cells that are not obstacles: labels, and frames around other cells."""


def read_obstacle(drawing: Drawing, cell: Cell) -> None:
    """Read a cell without a type as an obstacle, if it is a shape and not a decoration.

    Raises:
        BadCell: A number of the style is invalid.
    """
    if cell.geometry is None and cell.own.get("vertex") == "1":
        drawing.warn(cell, "has no mxGeometry, so it is nowhere and left out")
    if not cell.is_shape or not cell.style or _is_decoration(drawing, cell):
        return
    box = cell.box
    if cell.style.get("shape") == "mxgraph.floorplan.wall":
        box = box._replace(width=box.width or 1.0, height=box.height or 1.0)
    if not box.width or not box.height:
        drawing.warn(cell, f"has the size {box.width:g} x {box.height:g}, so it is not an obstacle")
        return
    if (thick := thickness(cell.style)) > min(box.width, box.height):
        size = f"{box.width:g} x {box.height:g}"
        drawing.warn(cell, f"wallThickness is {thick:g}, more than its size of {size}, so it is solid", thick)
    for outline in outlines(box, cell.style):
        drawing.lines["walls", len(drawing.walls)] = cell.line
        drawing.walls.append({"solid": [list(point) for point in outline]})


def _is_decoration(drawing: Drawing, cell: Cell) -> bool:
    parent = drawing.by_id.get(cell.parent)
    shape = cell.style.get("shape", "")
    return (
        not _DECORATION.isdisjoint(cell.style)
        or shape in _DECORATION
        or (cell.style.get("container") == "1" and not shape.startswith("mxgraph.floorplan."))
        or (parent is not None and parent.is_edge)
    )


def read_item(drawing: Drawing, cell: Cell) -> None:
    """Read an item that robots can pick up.

    Raises:
        BadCell: The name is missing or taken, or the weight is not a number.
    """
    name = cell.attributes.get("name", "")
    if not name:
        raise BadCell("has no name; items are picked up by it")
    weight = read_number(cell.attributes.get("weight", "0"), "weight")
    drawing.keep(cell, "items", name, {"at": list(cell.box.center), "weight": weight})


def read_place(drawing: Drawing, cell: Cell) -> None:
    """Read a point of interest as a place.

    Raises:
        BadCell: The name is taken.
    """
    drawing.keep(cell, "places", drawing.name(cell, "tag", "POI"), {"at": list(cell.box.center)})
