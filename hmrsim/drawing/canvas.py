"""SVG elements as text, and the canvas that all parts of a picture share: world, frame, colors and sizes."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias

from hmrsim.geometry import distance
from hmrsim.world_checks.resolved import type_order

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World


Attributes: TypeAlias = "dict[str, str | float]"
"""The attributes of an element, by name."""

_NOT_XML: Final = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML documents must not contain, not even escaped."""


def text_of(text: str) -> str:
    """Return a string as the content of an element, or of an attribute."""
    return escape(_NOT_XML.sub("\ufffd", text))


def number(value: float) -> str:
    """Return a number with at most two decimals."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def element(tag: str, *content: str, **attributes: str | float) -> str:
    """Return an element.

    Names of *attributes* have ``_`` for ``-``; an underscore at the end is dropped, as in ``class_``.
    """
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{text_of(value) if isinstance(value, str) else number(value)}"'
        for key, value in attributes.items()
    )
    return f"<{tag}{written}>{''.join(content)}</{tag}>" if content else f"<{tag}{written}/>"


def group(kind: str, parts: Iterable[str], **attributes: str | float) -> str:
    """Return a group of elements, one per line; an empty text if there are none."""
    lines = "\n".join(parts)
    return element("g", f"\n{lines}\n", class_=kind, **attributes) if lines else ""


def titled(title: str) -> str:
    """Return a title element, which browsers show as the tooltip of its parent."""
    return element("title", text_of(title))


def path(points: Iterable[Point], *, closed: bool = False) -> str:
    """Return the path data of straight lines through points."""
    steps = "L".join(f"{number(x)} {number(y)}" for x, y in points)
    return f"M{steps}{'Z' if closed else ''}"


PALETTE: Final[dict[str, Any]] = json.loads(files("hmrsim.drawing").joinpath("palette.json").read_text("utf-8"))
"""Colors by meaning and theme, color scales, and the colors of types, states and statuses."""

THEMES: Final = ("light", "dark")

BODIES: Final[dict[str, Any]] = PALETTE["bodies"]
"""Shapes of robots as SVG paths in the unit circle, facing +x."""


class Look(NamedTuple):
    """The color and shape (an SVG path) of robots of a type."""

    color: str
    shape: str


def type_looks(world: World) -> dict[str, Look]:
    """Return the look of each type that the world's robots have, in the order of the robots."""
    used = {robot.type for robot in world.robots.values()}
    colors, shapes = PALETTE["types"], BODIES["types"]
    return {
        name: Look(colors[number % len(colors)], shapes[number % len(shapes)])
        for number, name in enumerate(type_order(world))
        if name in used
    }


Box = tuple[float, float, float, float]
"""Least x, least y, greatest x, greatest y."""

_TALLEST: Final = 1.25
"""Maximum height of a map, in widths."""
_AROUND: Final = 0.04
"""Margin on each side of a world without bounds, as a share of its size."""


def extent(world: World) -> Box | None:
    """Return the least and greatest x and y of all entities, or None for an empty world."""
    points = list(_points(world))
    if not points:
        return None
    xs, ys = zip(*points, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def _points(world: World) -> Iterator[Point]:
    yield from world.points.values()
    for outline in world.outlines:
        yield from outline
    located = (world.places, world.docks, world.robots, world.items)
    yield from (world.point(entity.at) for entities in located for entity in entities.values())
    for door in world.doors.values():
        yield from door.at


@dataclass(frozen=True)
class Frame:
    """A window onto a world, in pixels of a picture.

    Attributes:
        box: The visible part of the world.
        scale: Pixels per unit of the world.
        left: The left edge of the window.
        top: The top edge of the window.
        up: Whether y points up in the world; in pictures it points down.
    """

    box: Box
    scale: float
    left: float
    top: float
    up: bool

    @classmethod
    def of(cls, world: World, width: float, *, left: float, top: float) -> Frame:
        """Return the frame that shows a whole world in a window of this width; a tall world is scaled down to fit."""
        x, y, to_x, to_y = _seen(world)
        scale = min(width / (to_x - x), width * _TALLEST / (to_y - y))
        beside = (width - (to_x - x) * scale) / 2
        return cls((x, y, to_x, to_y), scale, left + beside, top, up=world.units == "m")

    @property
    def size(self) -> Point:
        """Width and height, in pixels."""
        x, y, to_x, to_y = self.box
        return (to_x - x) * self.scale, (to_y - y) * self.scale

    def at(self, point: Point) -> Point:
        """Return the pixel of a point of the world."""
        x, y, _, to_y = self.box
        down = to_y - point[1] if self.up else point[1] - y
        return self.left + (point[0] - x) * self.scale, self.top + down * self.scale

    def length(self, a: Point, b: Point) -> float:
        """Return the distance between two points of the world, in pixels."""
        return distance(a, b) * self.scale


def _seen(world: World) -> Box:
    """Return the visible part of a world: its bounds, extended to entities outside of them."""
    whole, bounds = extent(world), world.bounds
    x, y, to_x, to_y = whole or bounds or (0.0, 0.0, 1.0, 1.0)
    if bounds:
        x, y, to_x, to_y = min(x, bounds[0]), min(y, bounds[1]), max(to_x, bounds[2]), max(to_y, bounds[3])
    longest = max(to_x - x, to_y - y) or 1.0
    if (x, y, to_x, to_y) != bounds:
        around = longest * _AROUND
        x, y, to_x, to_y = x - around, y - around, to_x + around, to_y + around
    # A single straight corridor has no width, but robots need some.
    lack_x, lack_y = (max(0.0, longest / 5 - side) / 2 for side in (to_x - x, to_y - y))
    return x - lack_x, y - lack_y, to_x + lack_x, to_y + lack_y


_MAX_MARK: Final = 7.0
_MIN_MARK: Final = 1.2


class Canvas:
    """A world with the frame, colors and sizes of its picture.

    Attributes:
        width: The width of the picture, in pixels.
        details: Whether speed limits and capacities are shown beside lanes.
        mark: The size of a mark, in pixels.
    """

    def __init__(self, world: World, colors: Mapping[str, str], frame: Frame, *, width: float, details: bool) -> None:
        self.world = world
        self.colors = colors
        self.types = type_looks(world)
        self.frame = frame
        self.width = width
        self.details = details
        self.mark = self._mark_size()

    def _mark_size(self) -> float:
        """Return the size of a mark in pixels, which is smaller in worlds with more entities."""
        world, (width, height) = self.world, self.frame.size
        count = sum(len(things) for things in (world.waypoints, world.places, world.docks, world.items, world.robots))
        return min(_MAX_MARK, max(_MIN_MARK, math.sqrt(width * height / max(1, count)) / 8))

    def robot_radius(self, name: str) -> float:
        """Return the radius in pixels at which a robot is drawn: its real one, but at least a visible minimum."""
        radius = self.world.robot_type(self.world.robots[name]).base.radius or 0.0
        # The shape of a body does not fill the circle.
        return max(1.2 * self.mark, radius * self.frame.scale)
