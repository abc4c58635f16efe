"""The outlines of draw.io's shapes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from hmrsim.world.formats._cells import style_number

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
    shape = style.get("shape", "").removeprefix("mxgraph.floorplan.")
    if shape in _BARS:
        thickness = max(style_number(style, "wallThickness", _THICKNESS), 1.0)
        drawn = _drawn(_BARS[shape], style)
        found = [_bar(box, side, thickness) for side in _SIDES if side in drawn]
    elif "ellipse" in style or shape == "ellipse":
        found = [_ellipse(box)]
    else:
        found = [_rectangle(box.x, box.y, box.width, box.height)]
    return [tuple(turn(point, box) for point in outline) for outline in found]


def _drawn(sides: tuple[str, ...], style: dict[str, str]) -> set[str]:
    """Return where the sides of a shape are in its box: draw.io turns it in there, and flips it then."""
    quarters = _DIRECTIONS.get(style.get("direction", ""), 0)
    drawn = {_SIDES[(_SIDES.index(side) + quarters) % 4] for side in sides}
    for flag, other in _FLIPS.items():
        if style.get(flag) == "1":
            drawn = {other.get(side, side) for side in drawn}
    return drawn


def _rectangle(x: float, y: float, width: float, height: float) -> Outline:
    return ((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def _bar(box: Box, side: str, thickness: float) -> Outline:
    """Return one wall inside a box, along one of its sides; at most as thick as the box."""
    thick_x, thick_y = min(thickness, box.width), min(thickness, box.height)
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
