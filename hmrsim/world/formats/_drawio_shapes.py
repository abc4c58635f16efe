"""Shapes of draw.io pages: their outlines as obstacles, items and named points."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hmrsim.diagnostics import shown
from hmrsim.world.formats._drawio_cells import BadCell, read_number, style_number, turn

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.formats._drawio_cells import Box, Cell
    from hmrsim.world.formats._drawio_drawing import Drawing

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
    """Return the sides of a shape in its box, which draw.io first rotates, then flips."""
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


def obstacle(drawing: Drawing, cell: Cell) -> None:
    """Read a bare cell: a shape that is not a decoration is an obstacle.

    Raises:
        BadCell: A number of its style is invalid.
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


def pickable(drawing: Drawing, cell: Cell) -> None:
    """Read an item.

    Raises:
        BadCell: It has no name, or one that is taken, or a weight that is not a number.
    """
    name = cell.attributes.get("name", "")
    if not name:
        raise BadCell("has no name; items are picked up by it")
    weight = read_number(cell.attributes.get("weight", "0"), "weight")
    drawing.keep(cell, "items", name, {"at": list(cell.box.center), "weight": weight})


def poi(drawing: Drawing, cell: Cell) -> None:
    """Read a named point.

    Raises:
        BadCell: Its name is taken.
    """
    drawing.keep(cell, "places", drawing.name(cell, "tag", "POI"), {"at": list(cell.box.center)})
