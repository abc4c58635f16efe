"""The names in a picture, as far as there is room for them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.drawing.labels import Labels, shortened, width_of
from hmrsim.drawing.lanes import limits
from hmrsim.drawing.svg import Attributes, element, group, text_of

if TYPE_CHECKING:
    from hmrsim.drawing.canvas import Canvas
    from hmrsim.geometry import Point

_SIZE: Final = 11.0
_SMALL: Final = 9.0
_BOLD: Final = "700"
_BOLDER: Final = 1.08
"""How much wider bold texts are."""

_ROOM: Final = 3.6
"""Minimum size of marks with names, as there is no room for most names beside smaller ones."""
_ROOM_FOR_WAYPOINTS: Final = 5.0


class _Name(NamedTuple):
    """A text beside a mark."""

    text: str
    at: Point
    radius: float
    size: float
    colour: str
    weight: str = "400"


def names(drawing: Canvas) -> str:
    """Return the names of robots, places, docks, lifts, items, doors and waypoints; the first have first choice."""
    if drawing.mark < _ROOM:
        return ""
    frame = drawing.frame
    width, height = frame.size
    labels = Labels((frame.left, frame.top, frame.left + width, frame.top + height))
    wanted = list(_wanted(drawing))
    for name in wanted:
        (x, y), half = name.at, name.radius
        labels.block((x - half, y - half, x + half, y + half))
    for wall in drawing.world.walls:
        points = [frame.at(point) for point in (wall if isinstance(wall, tuple) else (*wall.solid, wall.solid[0]))]
        for a, b in pairwise(points):
            labels.avoid(a, b)
    for lane in drawing.world.lanes:
        a, b = (frame.at(drawing.world.points[end]) for end in (lane.from_, lane.to))
        labels.avoid(a, b)
    look: Attributes = {
        "stroke": drawing.colours["floor"],
        "stroke_width": 2.5,
        "stroke_linejoin": "round",
        "paint_order": "stroke",
    }
    return group("names", _placed(wanted, labels), text_anchor="middle", **look)


def _placed(wanted: list[_Name], labels: Labels) -> Iterator[str]:
    for name in wanted:
        text = shortened(name.text)
        width = width_of(text, name.size) * (_BOLDER if name.weight == _BOLD else 1.0)
        middle = labels.place(name.at, name.radius, width, name.size * 1.15)
        if middle is not None:
            x, y = middle[0], middle[1] + name.size * 0.36
            look: Attributes = {"fill": name.colour, "font_size": name.size, "font_weight": name.weight}
            yield element("text", text_of(text), x=x, y=y, **look)


def _wanted(drawing: Canvas) -> Iterator[_Name]:
    world, at, size, colours = drawing.world, drawing.frame.at, drawing.mark, drawing.colours
    for name, robot in world.robots.items():
        yield _Name(name, at(world.point(robot.at)), drawing.robot_radius(name), _SIZE, colours["ink"], _BOLD)
    for name, place in world.places.items():
        yield _Name(name, at(place.at), size * 0.8, _SIZE, colours["place"])
    for name, dock in world.docks.items():
        colour = colours["charger" if dock.charges else "muted"]
        yield _Name(name, at(world.dock_point(name)), size * 1.5, _SMALL, colour)
    for name, lift in world.lifts.items():
        yield from (_Name(name, at(world.points[stop]), size * 1.3, _SMALL, colours["lift"]) for stop in lift.stops)
    for name, item in world.items.items():
        yield _Name(name, at(world.point(item.at)), size * 0.6, _SMALL, colours["item"])
    for name, door in world.doors.items():
        yield _Name(name, _middle(at(door.at[0]), at(door.at[1])), 3.0, _SMALL, colours["door"])
    if drawing.details:
        yield from _limits(drawing)
    for name, point in world.points.items() if size >= _ROOM_FOR_WAYPOINTS else ():
        yield _Name(name, at(point), size * 0.4, _SMALL, colours["muted"])


def _limits(drawing: Canvas) -> Iterator[_Name]:
    world = drawing.world
    for lane in world.lanes:
        text = ", ".join(limits(lane, world.units))
        if text:
            a, b = (drawing.frame.at(world.points[end]) for end in (lane.from_, lane.to))
            yield _Name(text, _middle(a, b), 1.0, _SMALL, drawing.colours["lane"])


def _middle(a: Point, b: Point) -> Point:
    return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
