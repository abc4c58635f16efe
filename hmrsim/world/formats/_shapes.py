"""The outlines of draw.io's shapes."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.geometry import Point
    from hmrsim.world.formats._mxgraph import Box

Outline = tuple["Point", ...]

_THICKNESS = 10.0
"""Of the walls of rooms and corners, px."""

_ELLIPSE_CORNERS = 24

_QUARTERS = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
"""Exact cosine and sine of quarter turns."""

_CORNERS = {
    "east": ("left", "top"),
    "north": ("left", "bottom"),
    "south": ("right", "top"),
    "west": ("right", "bottom"),
}
"""The bars of a wallCorner by its direction."""


def outlines(box: Box, style: dict[str, str]) -> list[Outline]:
    """Return what a shape covers: closed outlines, turned as it is."""
    shape = style.get("shape", "").removeprefix("mxgraph.floorplan.")
    if shape == "wallU":
        found = [_bar(box, side) for side in ("left", "top", "right")]
    elif shape == "wallCorner":
        found = [_bar(box, side) for side in _CORNERS.get(style.get("direction", ""), _CORNERS["east"])]
    elif shape == "room":
        found = [_bar(box, side) for side in ("left", "top", "right", "bottom")]
    elif "ellipse" in style or shape == "ellipse":
        found = [_ellipse(box)]
    else:
        found = [_rectangle(box.x, box.y, box.width, box.height)]
    turn = _turn(box)
    return [tuple(turn(point) for point in outline) for outline in found]


def _rectangle(x: float, y: float, width: float, height: float) -> Outline:
    return ((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def _bar(box: Box, side: str) -> Outline:
    """Return one wall inside a box, along one of its sides."""
    thick_x, thick_y = min(_THICKNESS, box.width), min(_THICKNESS, box.height)
    if side == "left":
        return _rectangle(box.x, box.y, thick_x, box.height)
    if side == "right":
        return _rectangle(box.x + box.width - thick_x, box.y, thick_x, box.height)
    if side == "top":
        return _rectangle(box.x, box.y, box.width, thick_y)
    return _rectangle(box.x, box.y + box.height - thick_y, box.width, thick_y)


def _ellipse(box: Box) -> Outline:
    a, b = box.width / 2, box.height / 2
    angles = [math.tau * i / _ELLIPSE_CORNERS for i in range(_ELLIPSE_CORNERS)]
    return tuple((box.x + a + a * math.cos(angle), box.y + b + b * math.sin(angle)) for angle in angles)


def _turn(box: Box) -> Callable[[Point], Point]:
    """Return what turns a point about the centre of a box, clockwise where y points down."""
    degrees = box.rotation % 360
    angle = math.radians(degrees)
    cos, sin = _QUARTERS.get(degrees) or (math.cos(angle), math.sin(angle))
    x, y = box.x + box.width / 2, box.y + box.height / 2

    def turn(point: Point) -> Point:
        dx, dy = point[0] - x, point[1] - y
        # Rounded, so that files mean the same wherever sine and cosine differ in their last digit.
        return (round(x + dx * cos - dy * sin, 6), round(y + dx * sin + dy * cos, 6))

    return turn
