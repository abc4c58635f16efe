"""The heat map of a report: the traffic of each lane, and the waiting times of robots by place."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final

from hmrsim.drawing import PALETTE, Drawing
from hmrsim.drawing.svg import element, group, titled
from hmrsim.report.wording import seconds, times

if TYPE_CHECKING:
    from hmrsim.drawing.canvas import Frame
    from hmrsim.report.model import Report
    from hmrsim.world.model import World

STEPS: Final = 6
"""Colours, from seldom to often."""

_MAX_WIDTH: Final = 9.0
_MAX_RADIUS: Final = 26.0
_MIN_RADIUS: Final = 3.0


def heat_map(report: Report, world: World) -> str:
    """Return the map as SVG, in the page's colours."""
    colors = {name: f"var(--{name.replace('_', '-')})" for name in PALETTE["light"]}
    drawing = Drawing(world, width=1100.0, legend=False, colors=colors)
    most = most_drives(report)
    looks, notes = {}, {}
    for lane in report.lanes:
        if lane.begin and lane.drives:
            step = step_of(lane.drives, most)
            looks[lane.begin, lane.end] = f"var(--heat-{step})", 2.0 + (_MAX_WIDTH - 2.0) * step / STEPS
            waited = f", {times(lane.waits, 'wait')}, {seconds(lane.waited)} in all" if lane.waits else ""
            notes[lane.begin, lane.end] = f"driven {times(lane.drives)}{waited}"
    svg = drawing.svg(looks, lane_notes=notes)
    over = group("paths", _paths(report, drawing.frame, most)) + group("waits", _waits(report, drawing.frame))
    return f"{svg.removesuffix('</svg>')}{over}</svg>"


def most_drives(report: Report) -> int:
    """Return the number of drives of the most used lane or segment, in one direction."""
    return max([1, *(lane.drives for lane in report.lanes if lane.begin), *(path.drives for path in report.paths)])


def step_of(drives: int, most: int) -> int:
    """Return the colour of a number of drives, from 1."""
    return max(1, math.ceil(STEPS * drives / most))


def _paths(report: Report, frame: Frame, most: int) -> Iterator[str]:
    for path in report.paths:
        (x1, y1), (x2, y2) = frame.at(path.begin), frame.at(path.end)
        step = step_of(path.drives, most)
        look = {"stroke": f"var(--heat-{step})", "stroke_dasharray": "2 3", "stroke_linecap": "round"}
        title = titled(f"off the lanes: driven {times(path.drives)}")
        yield element("line", title, x1=x1, y1=y1, x2=x2, y2=y2, stroke_width=1.5 + step / 2, **look)


def _waits(report: Report, frame: Frame) -> Iterator[str]:
    spots: dict[tuple[float, float], list[float]] = defaultdict(list)
    for wait in report.waits:
        if wait.x is not None and wait.y is not None:
            spots[round(wait.x, 1), round(wait.y, 1)].append(wait.duration)
    longest = max(map(sum, spots.values()), default=0.0) or 1.0
    for at, waits in sorted(spots.items(), key=lambda spot: (-sum(spot[1]), spot[0])):
        x, y = frame.at(at)
        radius = max(_MIN_RADIUS, _MAX_RADIUS * math.sqrt(sum(waits) / longest))
        title = titled(f"{times(len(waits), 'wait')} at ({at[0]:g}, {at[1]:g}), {seconds(sum(waits))} in all")
        yield element("circle", title, class_="waited", cx=x, cy=y, r=radius)
