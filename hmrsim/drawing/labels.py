"""The labels of a picture: each is beside its mark, or away from it with a line, or omitted if there is no room."""

from __future__ import annotations

import itertools
import math
import unicodedata
from collections import defaultdict
from collections.abc import Iterator
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

from hmrsim.drawing.canvas import Attributes, element, group, path, text_of
from hmrsim.drawing.marks import limits

if TYPE_CHECKING:
    from hmrsim.drawing.canvas import Box, Canvas
    from hmrsim.geometry import Point

_CELL: Final = 32.0
_GAP: Final = 2.0
_STEP: Final = 6.0
_MAX_STEPS: Final = 2000
"""Maximum number of points that represent a line."""
_AROUND: Final = ((1, 0), (-1, 0), (0, -1), (0, 1), (1, -1), (-1, -1), (1, 1), (-1, 1))
"""The sides of a mark, best first: to the right, to the left, above, below, …"""
_BESIDE: Final = (*((1, x, y) for x, y in _AROUND), *((3, x, y) for x, y in _AROUND[:4]))
"""The positions of a label as gaps and sides, best first."""
_AWAY: Final = tuple(
    (far, side, along) for far in (14.0, 28.0, 45.0, 65.0) for side in (-1, 1) for along in (0.0, 0.45, -0.45)
)
"""The positions of a label above or below its mark, to which a line leads: pixels, side, and shift in widths."""
_MAX_LETTERS: Final = 28

_SIZE: Final = 11.0
_SMALL: Final = 9.0
_BOLD: Final = "700"
_BOLDER: Final = 1.08
"""The width of bold text relative to normal text."""

_ROOM: Final = 3.6
"""Minimum size of marks with names; most names don't fit beside smaller ones."""
_ROOM_FOR_WAYPOINTS: Final = 5.0


def shortened(text: str, longest: int = _MAX_LETTERS) -> str:
    """Return a text, truncated if it is long."""
    return text if len(text) <= longest else f"{text[: longest - 1]}…"


def width_of(text: str, size: float) -> float:
    """Return the approximate width of a line of text in a wide font."""
    wide = sum(unicodedata.east_asian_width(character) in "WF" for character in text)
    return (len(text) * 0.6 + wide * 0.4) * size


class Labels:
    """The parts of a picture that marks and labels occupy; no label extends beyond *within*."""

    def __init__(self, within: Box) -> None:
        self._within = within
        self._boxes: defaultdict[Point, list[Box]] = defaultdict(list)
        self._lines: defaultdict[Point, list[Point]] = defaultdict(list)

    def block(self, box: Box) -> None:
        """Keep labels out of a box, which can be far larger than the picture."""
        x, y, to_x, to_y = self._within
        seen = max(box[0], x), max(box[1], y), min(box[2], to_x), min(box[3], to_y)
        for cell in _cells(seen):
            self._boxes[cell].append(seen)

    def avoid(self, a: Point, b: Point) -> None:
        """Keep labels off a line, if they have another place."""
        steps = min(_MAX_STEPS, max(1, int(math.dist(a, b) / _STEP)))
        for step in range(steps + 1):
            x, y = (a[axis] + (b[axis] - a[axis]) * step / steps for axis in (0, 1))
            self._lines[x // _CELL, y // _CELL].append((x, y))

    def place(self, at: Point, radius: float, width: float, height: float) -> tuple[Point, Point | None] | None:
        """Occupy a place for a label: beside its mark, else above or below it.

        Returns:
            Its middle, and the end of the line that leads to it if it is not beside its mark; None if there is no room.
        """
        best: tuple[int, Point] | None = None
        for gaps, side_x, side_y in _BESIDE:
            aside = radius + gaps * _GAP
            middle = (at[0] + side_x * (aside + width / 2), at[1] + side_y * (aside + height / 2))
            box = _box(middle, width, height)
            if not self._free(box):
                continue
            crossed = self._crossed(box)
            if best is None or crossed < best[0]:
                best = crossed, middle
            if not crossed:
                break
        if best is not None:
            self.block(_box(best[1], width, height))
            return best[1], None
        for far, side, along in _AWAY:
            end = (at[0], at[1] + side * (radius + far))
            middle = (at[0] + along * width, end[1] + side * height / 2)
            line = _box((at[0], at[1] + side * (radius + far / 2)), 1.0, far)
            box = _box(middle, width, height)
            if self._free(box) and self._free(line):
                self.block(box)
                self.block(line)
                return middle, end
        return None

    def _free(self, box: Box) -> bool:
        x, y, to_x, to_y = self._within
        if box[0] < x or box[1] < y or box[2] > to_x or box[3] > to_y:
            return False
        return not any(_meet(box, other) for cell in _cells(box) for other in self._boxes.get(cell, ()))

    def _crossed(self, box: Box) -> int:
        points = (point for cell in _cells(box) for point in self._lines.get(cell, ()))
        return sum(box[0] <= x <= box[2] and box[1] <= y <= box[3] for x, y in points)


def _box(middle: Point, width: float, height: float) -> Box:
    x, y = middle
    return x - width / 2, y - height / 2, x + width / 2, y + height / 2


def _cells(box: Box) -> Iterator[Point]:
    xs, ys = (range(int(box[axis] // _CELL), int(box[axis + 2] // _CELL) + 1) for axis in (0, 1))
    return itertools.product(xs, ys)


def _meet(a: Box, b: Box) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


class _Name(NamedTuple):
    """A label beside a mark."""

    text: str
    at: Point
    radius: float
    size: float
    color: str
    weight: str = "400"


def names(drawing: Canvas, clear: float = 0.0) -> str:
    """Return the names of robots, places, docks, lifts, items, doors and waypoints, placed in this order.

    Args:
        drawing: The picture.
        clear: The minimum distance in pixels between a mark and its name, such as for robots that stop there.
    """
    if drawing.mark < _ROOM:
        return ""
    frame = drawing.frame
    width, height = frame.size
    labels = Labels((frame.left, frame.top, frame.left + width, frame.top + height))
    labeled = [name._replace(radius=max(clear, name.radius)) for name in _labels_of(drawing)]
    for name in labeled:
        (x, y), half = name.at, name.radius
        labels.block((x - half, y - half, x + half, y + half))
    for outline in drawing.world.outlines:
        for a, b in pairwise(map(frame.at, outline)):
            labels.avoid(a, b)
    for lane in drawing.world.lanes:
        a, b = (frame.at(drawing.world.points[end]) for end in (lane.from_, lane.to))
        labels.avoid(a, b)
    look: Attributes = {
        "stroke": drawing.colors["floor"],
        "stroke_width": 2.5,
        "stroke_linejoin": "round",
        "paint_order": "stroke",
    }
    return group("names", _placed(labeled, labels), text_anchor="middle", **look)


def _placed(labeled: list[_Name], labels: Labels) -> Iterator[str]:
    for name in labeled:
        text = shortened(name.text)
        width = width_of(text, name.size) * (_BOLDER if name.weight == _BOLD else 1.0)
        placed = labels.place(name.at, name.radius, width, name.size * 1.15)
        if placed is None:
            continue
        (x, y), line = placed
        if line is not None:
            yield element("path", d=path((name.at, line)), stroke=name.color, stroke_width=0.8, stroke_opacity=0.6)
        look: Attributes = {"fill": name.color, "font_size": name.size, "font_weight": name.weight}
        yield element("text", text_of(text), x=x, y=y + name.size * 0.36, **look)


def _labels_of(drawing: Canvas) -> Iterator[_Name]:
    world, at, size, colors = drawing.world, drawing.frame.at, drawing.mark, drawing.colors
    for name, robot in world.robots.items():
        yield _Name(name, at(world.point(robot.at)), drawing.robot_radius(name), _SIZE, colors["ink"], _BOLD)
    for name, place in world.places.items():
        yield _Name(name, at(place.at), size * 0.8, _SIZE, colors["place"])
    for name, dock in world.docks.items():
        color = colors["charger" if dock.charges else "muted"]
        yield _Name(name, at(world.dock_point(name)), size * 1.5, _SMALL, color)
    for name, lift in world.lifts.items():
        yield from (_Name(name, at(world.points[stop]), size * 1.3, _SMALL, colors["lift"]) for stop in lift.stops)
    for name, item in world.items.items():
        yield _Name(name, at(world.point(item.at)), size * 0.6, _SMALL, colors["item"])
    for name, door in world.doors.items():
        yield _Name(name, _middle(at(door.at[0]), at(door.at[1])), 3.0, _SMALL, colors["door"])
    if drawing.details:
        yield from _limits(drawing)
    for name, point in world.points.items() if size >= _ROOM_FOR_WAYPOINTS else ():
        yield _Name(name, at(point), size * 0.4, _SMALL, colors["muted"])


def _limits(drawing: Canvas) -> Iterator[_Name]:
    world = drawing.world
    for lane in world.lanes:
        text = ", ".join(limits(lane, world.units))
        if text:
            a, b = (drawing.frame.at(world.points[end]) for end in (lane.from_, lane.to))
            yield _Name(text, _middle(a, b), 1.0, _SMALL, drawing.colors["lane"])


def _middle(a: Point, b: Point) -> Point:
    return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2
