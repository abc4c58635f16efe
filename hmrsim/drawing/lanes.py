"""Lanes in a picture: their directions, and how much traffic takes them if that was counted."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Final

from hmrsim.drawing import marks
from hmrsim.drawing.svg import Attributes, element, path, titled

if TYPE_CHECKING:
    from hmrsim.drawing.frame import Frame
    from hmrsim.geometry import Point
    from hmrsim.world.model import Lane, World

_WIDTH: Final = 1.3
_MAX_TRACKS: Final = 4


def lanes(
    world: World,
    frame: Frame,
    size: float,
    colours: Mapping[str, str],
    counted: Mapping[tuple[str, str], tuple[str, float]],
    notes: Mapping[tuple[str, str], str],
) -> Iterator[str]:
    """Return an element for each lane, and behind it one for each direction that has a colour of its own."""
    for lane in world.lanes:
        a, b = (frame.at(world.points[name]) for name in (lane.from_, lane.to))
        arrow = marks.chevron(a, b, size) if lane.one_way else ""
        tracks = min(_MAX_TRACKS, lane.capacity or 1)
        look: Attributes = {"stroke": colours["lane"], "stroke_width": _WIDTH + (tracks - 1) * 0.6}
        yield element("path", titled(about(lane, world.units)), d=path((a, b)) + arrow, **look)
        ways = {(lane.from_, lane.to): (a, b), (lane.to, lane.from_): (b, a)}
        both = all(way in counted for way in ways)
        for way, (start, end) in ways.items():
            if way in counted:
                colour, width = counted[way]
                line = path(_beside(start, end, width / 2 + 0.4) if both else (start, end))
                title = titled(f"{way[0]} → {way[1]}: {notes[way]}") if way in notes else ""
                yield element("path", title, d=line + arrow, stroke=colour, stroke_width=width)


def _beside(a: Point, b: Point, aside: float) -> tuple[Point, Point]:
    """Return a line that is moved to the right, as seen in its direction."""
    length = math.dist(a, b) or 1.0
    x, y = -(b[1] - a[1]) / length * aside, (b[0] - a[0]) / length * aside
    return (a[0] + x, a[1] + y), (b[0] + x, b[1] + y)


def about(lane: Lane, units: str) -> str:
    """Return what there is to know of a lane, on a line."""
    parts = [f"{lane.from_} {'→' if lane.one_way else '↔'} {lane.to}", *limits(lane, units)]
    return ", ".join(parts)


def limits(lane: Lane, units: str) -> list[str]:
    """Return how fast and how many may be on a lane, as far as it says so."""
    speed = [f"≤ {lane.speed_limit:g} {units}/s"] if lane.speed_limit else []
    return [*speed, *([f"{lane.capacity} at once"] if lane.capacity else [])]
