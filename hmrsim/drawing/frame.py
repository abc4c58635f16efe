"""The transformation from a world's coordinates to those of a picture."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from hmrsim.geometry import distance

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.model import World

Box = tuple[float, float, float, float]
"""Least x, least y, greatest x, greatest y."""

_TALLEST: Final = 1.25
"""Greatest height of a map, in its widths."""
_AROUND: Final = 0.04
"""Share of a world without bounds that is left free on each side."""


def extent(world: World) -> Box | None:
    """Return least and greatest x and y of all entities; None in an empty world."""
    points = list(_points(world))
    if not points:
        return None
    xs, ys = zip(*points, strict=True)
    return min(xs), min(ys), max(xs), max(ys)


def _points(world: World) -> Iterator[Point]:
    yield from world.points.values()
    for wall in world.walls:
        yield from wall if isinstance(wall, tuple) else wall.solid
    named = (world.places, world.docks, world.robots, world.items)
    yield from (world.point(thing.at) for things in named for thing in things.values())
    for door in world.doors.values():
        yield from door.at


@dataclass(frozen=True)
class Frame:
    """A window onto a world, in pixels of a picture.

    Attributes:
        box: What of the world is seen.
        scale: Pixels for one of the world's unit.
        left: Where the window begins, from the left.
        top: Likewise, from above.
        up: Whether y points up in the world; in pictures it points down.
    """

    box: Box
    scale: float
    left: float
    top: float
    up: bool

    @classmethod
    def of(cls, world: World, width: float, *, left: float, top: float) -> Frame:
        """Return the frame that shows all of a world in a window of a width, less where that would be too tall."""
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
        """Return where a point of the world is in the picture."""
        x, y, _, to_y = self.box
        down = to_y - point[1] if self.up else point[1] - y
        return self.left + (point[0] - x) * self.scale, self.top + down * self.scale

    def length(self, a: Point, b: Point) -> float:
        """Return how far two points of the world are from each other in the picture."""
        return distance(a, b) * self.scale


def _seen(world: World) -> Box:
    """Return the visible part of a world: its bounds, extended to entities outside of them."""
    found, bounds = extent(world), world.bounds
    x, y, to_x, to_y = found or bounds or (0.0, 0.0, 1.0, 1.0)
    if bounds:
        x, y, to_x, to_y = min(x, bounds[0]), min(y, bounds[1]), max(to_x, bounds[2]), max(to_y, bounds[3])
    longest = max(to_x - x, to_y - y) or 1.0
    if (x, y, to_x, to_y) != bounds:
        around = longest * _AROUND
        x, y, to_x, to_y = x - around, y - around, to_x + around, to_y + around
    # A corridor without walls has no width, but what stands there has.
    lack_x, lack_y = (max(0.0, longest / 5 - side) / 2 for side in (to_x - x, to_y - y))
    return x - lack_x, y - lack_y, to_x + lack_x, to_y + lack_y
