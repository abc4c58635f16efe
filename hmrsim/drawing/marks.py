"""The marks of a picture, each drawn around a point."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from hmrsim.drawing.palette import BODIES
from hmrsim.drawing.svg import Attributes, element, number, path

if TYPE_CHECKING:
    from hmrsim.drawing.palette import Look
    from hmrsim.geometry import Point


def waypoint(at: Point, size: float, colours: Mapping[str, str], *content: str) -> str:
    """Return a dot."""
    return element("circle", *content, cx=at[0], cy=at[1], r=size * 0.4, fill=colours["waypoint"])


def place(at: Point, size: float, colours: Mapping[str, str], *content: str) -> str:
    """Return a ring around a dot."""
    x, y = at
    return element(
        "g",
        *content,
        element("circle", cx=x, cy=y, r=size * 0.8, fill=colours["floor"], stroke=colours["place"], stroke_width=1.4),
        element("circle", cx=x, cy=y, r=size * 0.3, fill=colours["place"]),
    )


def dock(at: Point, size: float, colours: Mapping[str, str], *content: str, charges: bool) -> str:
    """Return a square; with a flash in it where batteries are charged."""
    (x, y), half = at, size * 1.5
    colour = colours["charger" if charges else "dock"]
    look: Attributes = {"fill": colour, "fill_opacity": 0.15, "stroke": colour, "stroke_width": 1.4}
    square = element("rect", x=x - half, y=y - half, width=2 * half, height=2 * half, rx=half / 4, **look)
    flash = element("path", d=path(_flash(at, half * 0.8), closed=True), fill=colour) if charges else ""
    return element("g", *content, square, flash)


def _flash(at: Point, size: float) -> list[Point]:
    corners = ((0.15, -1.0), (-0.55, 0.15), (-0.05, 0.15), (-0.15, 1.0), (0.55, -0.2), (0.05, -0.2))
    return [(at[0] + x * size, at[1] + y * size) for x, y in corners]


def door(a: Point, b: Point, colours: Mapping[str, str], *content: str) -> str:
    """Return a line between two jambs."""
    look: Attributes = {"stroke": colours["door"], "stroke_width": 2.5, "stroke_dasharray": "4 2", "fill": "none"}
    return element("path", *content, d=path((a, b)), **look)


def lift(at: Point, size: float, colours: Mapping[str, str], *content: str) -> str:
    """Return a cabin with an arrow up and one down."""
    (x, y), half = at, size * 1.3
    corners = ((-0.5, 0.2), (0.0, 0.75), (0.5, 0.2))
    arrows = "".join(path((x + dx * half, y + sign * half * dy) for dx, dy in corners) for sign in (-1, 1))
    look: Attributes = {"stroke": colours["lift"], "stroke_width": 1.4}
    return element(
        "g",
        *content,
        element("rect", x=x - half, y=y - half, width=2 * half, height=2 * half, fill=colours["floor"], **look),
        element("path", d=arrows, fill="none", **look),
    )


def item(at: Point, size: float, colours: Mapping[str, str], *content: str) -> str:
    """Return a small red box."""
    (x, y), half = at, max(1.5, size * 0.55)
    look: Attributes = {"fill": colours["item"], "stroke": colours["floor"], "stroke_width": 0.8}
    return element("rect", *content, x=x - half, y=y - half, width=2 * half, height=2 * half, rx=half / 3, **look)


def robot(
    at: Point, radius: float, yaw: float, look: Look, colours: Mapping[str, str], *content: str, flies: bool = False
) -> str:
    """Return the body of a robot, as the page draws it; *yaw* is clockwise, as pictures are."""
    width = max(0.6, radius * 0.1) / radius
    body = _flying(look, colours, width) if flies else _driving(look, colours, width)
    place = f"translate({number(at[0])} {number(at[1])})rotate({number(math.degrees(yaw))})scale({number(radius)})"
    return element("g", *content, body, transform=place)


def _driving(look: Look, colours: Mapping[str, str], width: float) -> str:
    ink = colours["robot_outline"]
    shape = element("path", d=look.shape, fill=look.colour, stroke=ink, stroke_width=width)
    return shape + element("path", d=BODIES["nose"], fill=ink)


def _flying(look: Look, colours: Mapping[str, str], width: float) -> str:
    """Return a small body between four rotors."""
    ink, rotors = colours["robot_outline"], BODIES["rotors"]
    corners = [(x, y) for x in (-rotors["at"], rotors["at"]) for y in (-rotors["at"], rotors["at"])]
    arms = "".join(path(((0.0, 0.0), corner)) for corner in corners)
    rotor: Attributes = {"r": rotors["radius"], "fill": look.colour, "fill_opacity": 0.55, "stroke": ink}
    return "".join(
        (
            element("path", d=arms, fill="none", stroke=ink, stroke_width=max(0.13, width)),
            *(element("circle", cx=x, cy=y, stroke_width=width, **rotor) for x, y in corners),
            element("g", _driving(look, colours, width / rotors["body"]), transform=f"scale({rotors['body']})"),
        )
    )


def chevron(a: Point, b: Point, size: float) -> str:
    """Return the data of an arrowhead in the middle of a line, which points where the line leads."""
    length = math.dist(a, b)
    if not length:
        return ""
    dx, dy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
    size = min(size, length / 3)
    tip = ((a[0] + b[0] + dx * size) / 2, (a[1] + b[1] + dy * size) / 2)
    sides = [(tip[0] - size * (dx + sign * dy * 0.8), tip[1] - size * (dy - sign * dx * 0.8)) for sign in (1, -1)]
    return path([sides[0], tip, sides[1]])
