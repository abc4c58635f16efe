"""The outlines of draw.io's shapes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hmrsim.diagnostics import shown
from hmrsim.world.formats._cells import BadCell, style_number

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.formats._cells import Box

Outline = tuple["Point", ...]

_THICKNESS = 10.0
"""Of the walls of rooms and corners, px."""

_ELLIPSE_CORNERS = 24

_QUARTERS = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
"""Exact cosine and sine of quarter turns."""

_SIDES = ("left", "top", "right", "bottom")
"""In clockwise order."""

_BARS = {"wallU": _SIDES[:3], "wallCorner": _SIDES[:2], "room": _SIDES}
"""The walls that a shape has, as drawn to the east."""

_DIRECTIONS = {"east": 0, "south": 1, "west": 2, "north": 3}
"""Quarter turns of a shape inside its box, clockwise."""

_FLIPS = {"flipH": {"left": "right", "right": "left"}, "flipV": {"top": "bottom", "bottom": "top"}}


def outlines(box: Box, style: dict[str, str]) -> list[Outline]:
    """Return what a shape covers: closed outlines, turned as it is.

    Raises:
        BadCell: A number of the style makes no sense.
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
    """Return how thick the walls of a shape are; 0 of one that covers all of its box.

    Raises:
        BadCell: That makes no sense.
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
    """Return where the sides of a shape are in its box: draw.io turns it in there, and flips it then."""
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


def turn(point: Point, box: Box) -> Point:
    """Return a point of a box after the box was turned about its middle, clockwise where y points down."""
    degrees = box.rotation % 360
    angle = math.radians(degrees)
    cos, sin = _QUARTERS.get(degrees) or (math.cos(angle), math.sin(angle))
    x, y = box.middle
    dx, dy = point[0] - x, point[1] - y
    # Rounded, so that files mean the same wherever sine and cosine differ in their last digit.
    return (round(x + dx * cos - dy * sin, 6), round(y + dx * sin + dy * cos, 6))
