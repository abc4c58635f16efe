"""The marks and lanes of a picture, and overlays on lanes: shares of traffic, and bottlenecks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from hmrsim.drawing.canvas import BODIES, PALETTE, Attributes, element, number, path, titled

if TYPE_CHECKING:
    from hmrsim.drawing.canvas import Frame, Look
    from hmrsim.geometry import Point
    from hmrsim.world.model import Lane, World


_WIDTH: Final = 1.3
_MAX_TRACKS: Final = 4


def waypoint(at: Point, size: float, colors: Mapping[str, str], *content: str) -> str:
    """Return a dot."""
    return element("circle", *content, cx=at[0], cy=at[1], r=size * 0.4, fill=colors["waypoint"])


def place(at: Point, size: float, colors: Mapping[str, str], *content: str) -> str:
    """Return a ring around a dot."""
    x, y = at
    return element(
        "g",
        *content,
        element("circle", cx=x, cy=y, r=size * 0.8, fill=colors["floor"], stroke=colors["place"], stroke_width=1.4),
        element("circle", cx=x, cy=y, r=size * 0.3, fill=colors["place"]),
    )


def dock(at: Point, size: float, colors: Mapping[str, str], *content: str, charges: bool) -> str:
    """Return a square, with a flash in it if the dock charges batteries."""
    (x, y), half = at, size * 1.5
    color = colors["charger" if charges else "dock"]
    look: Attributes = {"fill": color, "fill_opacity": 0.15, "stroke": color, "stroke_width": 1.4}
    square = element("rect", x=x - half, y=y - half, width=2 * half, height=2 * half, rx=half / 4, **look)
    flash = element("path", d=path(_flash(at, half * 0.8), closed=True), fill=color) if charges else ""
    return element("g", *content, square, flash)


def _flash(at: Point, size: float) -> list[Point]:
    corners = ((0.15, -1.0), (-0.55, 0.15), (-0.05, 0.15), (-0.15, 1.0), (0.55, -0.2), (0.05, -0.2))
    return [(at[0] + x * size, at[1] + y * size) for x, y in corners]


def door(a: Point, b: Point, colors: Mapping[str, str], *content: str) -> str:
    """Return a line between two jambs."""
    look: Attributes = {"stroke": colors["door"], "stroke_width": 2.5, "stroke_dasharray": "4 2", "fill": "none"}
    return element("path", *content, d=path((a, b)), **look)


def lift(at: Point, size: float, colors: Mapping[str, str], *content: str) -> str:
    """Return a cabin with an arrow up and one down."""
    (x, y), half = at, size * 1.3
    corners = ((-0.5, 0.2), (0.0, 0.75), (0.5, 0.2))
    arrows = "".join(path((x + dx * half, y + sign * half * dy) for dx, dy in corners) for sign in (-1, 1))
    look: Attributes = {"stroke": colors["lift"], "stroke_width": 1.4}
    return element(
        "g",
        *content,
        element("rect", x=x - half, y=y - half, width=2 * half, height=2 * half, fill=colors["floor"], **look),
        element("path", d=arrows, fill="none", **look),
    )


def item(at: Point, size: float, colors: Mapping[str, str], *content: str) -> str:
    """Return a small red box."""
    (x, y), half = at, max(1.5, size * 0.55)
    look: Attributes = {"fill": colors["item"], "stroke": colors["floor"], "stroke_width": 0.8}
    return element("rect", *content, x=x - half, y=y - half, width=2 * half, height=2 * half, rx=half / 3, **look)


def robot(
    at: Point, radius: float, yaw: float, look: Look, colors: Mapping[str, str], *content: str, flies: bool = False
) -> str:
    """Return the body of a robot, as on the page; *yaw* is clockwise, as in pictures."""
    width = max(0.6, radius * 0.1) / radius
    body = _flying(look, colors, width) if flies else _driving(look, colors, width)
    place = f"translate({number(at[0])} {number(at[1])})rotate({number(math.degrees(yaw))})scale({number(radius)})"
    return element("g", *content, body, transform=place)


def _driving(look: Look, colors: Mapping[str, str], width: float) -> str:
    ink = colors["robot_outline"]
    shape = element("path", d=look.shape, fill=look.color, stroke=ink, stroke_width=width)
    return shape + element("path", d=BODIES["nose"], fill=ink)


def _flying(look: Look, colors: Mapping[str, str], width: float) -> str:
    """Return a small body between four rotors."""
    ink, rotors = colors["robot_outline"], BODIES["rotors"]
    corners = [(x, y) for x in (-rotors["at"], rotors["at"]) for y in (-rotors["at"], rotors["at"])]
    arms = "".join(path(((0.0, 0.0), corner)) for corner in corners)
    rotor: Attributes = {"r": rotors["radius"], "fill": look.color, "fill_opacity": 0.55, "stroke": ink}
    return "".join(
        (
            element("path", d=arms, fill="none", stroke=ink, stroke_width=max(0.13, width)),
            *(element("circle", cx=x, cy=y, stroke_width=width, **rotor) for x, y in corners),
            element("g", _driving(look, colors, width / rotors["body"]), transform=f"scale({rotors['body']})"),
        )
    )


def chevron(a: Point, b: Point, size: float) -> str:
    """Return the path data of an arrowhead in the middle of a line, in its direction."""
    length = math.dist(a, b)
    if not length:
        return ""
    dx, dy = (b[0] - a[0]) / length, (b[1] - a[1]) / length
    size = min(size, length / 3)
    tip = ((a[0] + b[0] + dx * size) / 2, (a[1] + b[1] + dy * size) / 2)
    sides = [(tip[0] - size * (dx + sign * dy * 0.8), tip[1] - size * (dy - sign * dx * 0.8)) for sign in (1, -1)]
    return path([sides[0], tip, sides[1]])


def lanes(
    world: World,
    frame: Frame,
    size: float,
    colors: Mapping[str, str],
    counted: Mapping[tuple[str, str], tuple[str, float]],
    notes: Mapping[tuple[str, str], str],
) -> Iterator[str]:
    """Return an element for each lane, followed by one for each direction with another color."""
    for lane in world.lanes:
        a, b = (frame.at(world.points[name]) for name in (lane.from_, lane.to))
        arrow = chevron(a, b, size) if lane.one_way else ""
        tracks = min(_MAX_TRACKS, lane.capacity or 1)
        look: Attributes = {"stroke": colors["lane"], "stroke_width": _WIDTH + (tracks - 1) * 0.6}
        yield element("path", titled(about(lane, world.units)), d=path((a, b)) + arrow, **look)
        ways = {(lane.from_, lane.to): (a, b), (lane.to, lane.from_): (b, a)}
        both = all(way in counted for way in ways)
        for way, (start, end) in ways.items():
            if way in counted:
                color, width = counted[way]
                line = path(_beside(start, end, width / 2 + 0.4) if both else (start, end))
                title = titled(f"{way[0]} → {way[1]}: {notes[way]}") if way in notes else ""
                yield element("path", title, d=line + arrow, stroke=color, stroke_width=width)


def _beside(a: Point, b: Point, aside: float) -> tuple[Point, Point]:
    """Return a line shifted to the right, as seen in its direction."""
    length = math.dist(a, b) or 1.0
    x, y = -(b[1] - a[1]) / length * aside, (b[0] - a[0]) / length * aside
    return (a[0] + x, a[1] + y), (b[0] + x, b[1] + y)


def about(lane: Lane, units: str) -> str:
    """Return the description of a lane on one line."""
    parts = [f"{lane.from_} {'→' if lane.one_way else '↔'} {lane.to}", *limits(lane, units)]
    return ", ".join(parts)


def limits(lane: Lane, units: str) -> list[str]:
    """Return the speed limit and capacity of a lane, if it has them."""
    speed = [f"≤ {lane.speed_limit:g} {units}/s"] if lane.speed_limit else []
    return [*speed, *([f"{lane.capacity} at once"] if lane.capacity else [])]


_MIN_WIDTH: Final = 1.6
_MAX_WIDTH: Final = 8.0
_PER_MARK: Final = 1.2
_LEGEND_LINE: Final = ((0.0, 0.0), (18.0, 0.0))


@dataclass(frozen=True)
class Weak:
    """A bottleneck of the lanes, to be highlighted.

    Attributes:
        waypoints: The waypoint, the ends of the lane, or the stops of the lift.
        kind: The kind of bottleneck.
        weight: Its severity from 0 to 1, where 1 cuts off half of the map.
        note: The parts that it separates, as text.
    """

    waypoints: tuple[str, ...]
    kind: Literal["waypoint", "lane", "lift"]
    weight: float
    note: str


@dataclass(frozen=True)
class Overlay:
    """Traffic and bottlenecks of a map.

    Attributes:
        shares: The share of trips that use a lane, by the waypoints at its ends.
    """

    shares: Mapping[tuple[str, str], float]
    weak: tuple[Weak, ...]
    theme: Literal["light", "dark"] = "light"

    def looks(self, mark: float) -> dict[tuple[str, str], tuple[str, float]]:
        """Return the color and width of each lane with traffic, for this size of marks."""
        most = max(self.shares.values(), default=1.0)
        return {lane: self._look(share / most, mark) for lane, share in self.shares.items()}

    def notes(self) -> dict[tuple[str, str], str]:
        """Return the note of each lane with traffic."""
        return {lane: f"{share:.1%} of trips, either way" for lane, share in self.shares.items()}

    def _look(self, share: float, mark: float) -> tuple[str, float]:
        colors = PALETTE["heat"][self.theme]
        step = min(len(colors) - 1, int(share * len(colors)))
        widest = min(_MAX_WIDTH, max(2 * _MIN_WIDTH, mark * _PER_MARK))
        return colors[step], _MIN_WIDTH + (widest - _MIN_WIDTH) * share

    def beneath(self, world: World, frame: Frame, mark: float, colors: Mapping[str, str]) -> Iterator[str]:
        """Yield highlights under bottleneck lanes, and dashed lines for rides in lifts."""
        looks, points = self.looks(mark), world.points
        driven = {frozenset((lane.from_, lane.to)) for lane in world.lanes}
        for (a, b), (color, width) in looks.items():
            if frozenset((a, b)) not in driven:
                line = path((frame.at(points[a]), frame.at(points[b])))
                title = titled(f"{a} - {b}, a ride: {self.shares[a, b]:.1%} of trips, either way")
                yield element("path", title, d=line, stroke=color, stroke_width=width, stroke_dasharray="2 6")
        for weak in reversed(self.weak):
            if weak.kind == "lane":
                a, b = weak.waypoints
                taken = looks.get((a, b)) or looks.get((b, a)) or ("", _MIN_WIDTH)
                yield _shine(
                    (frame.at(points[a]), frame.at(points[b])),
                    taken[1] + mark * (0.5 + 0.9 * weak.weight),
                    colors,
                    titled(weak.note),
                )

    def above(self, world: World, frame: Frame, mark: float, colors: Mapping[str, str]) -> Iterator[str]:
        """Yield rings around bottleneck waypoints and lifts."""
        for weak in reversed(self.weak):
            if weak.kind != "lane":
                radius = mark * (0.6 + 0.9 * weak.weight) * (1.8 if weak.kind == "lift" else 1.0)
                for name in weak.waypoints:
                    yield _ring(frame.at(world.points[name]), radius, colors, titled(weak.note))

    def legend(self, colors: Mapping[str, str]) -> Iterator[tuple[str, str]]:
        """Yield marks and their meanings; marks are around (9, 0)."""
        if self.shares:
            heat = PALETTE["heat"][self.theme]
            parts = []
            for number, color in enumerate(heat):
                ends = ((number * 3.2, 0.0), (number * 3.2 + 3.2, 0.0))
                parts.append(element("path", d=path(ends), stroke=color, stroke_width=2.0 + number * 1.3))
            yield "".join(parts), f"up to {max(self.shares.values()):.0%} of trips"
        kinds = {weak.kind for weak in self.weak}
        if "lane" in kinds:
            line = element("path", d=path(_LEGEND_LINE), stroke=colors["lane"], stroke_width=_MIN_WIDTH)
            yield _shine(_LEGEND_LINE, 9.0, colors) + line, "bottleneck lane"
        if kinds - {"lane"}:
            yield _ring((9.0, 0.0), 6.0, colors), f"bottleneck {' or '.join(sorted(kinds - {'lane'}, reverse=True))}"


def _shine(ends: tuple[Point, Point], width: float, colors: Mapping[str, str], *content: str) -> str:
    look: Attributes = {"fill": "none", "stroke": colors["bottleneck"], "stroke_width": width}
    return element("path", *content, d=path(ends), **look, stroke_opacity=0.5, stroke_linecap="butt")


def _ring(at: Point, radius: float, colors: Mapping[str, str], *content: str) -> str:
    width = max(1.0, math.sqrt(radius) * 0.8)
    look: Attributes = {"fill": colors["floor"], "fill_opacity": 0.6, "stroke": colors["bottleneck"]}
    return element("circle", *content, cx=at[0], cy=at[1], r=radius, **look, stroke_width=width)
