"""Overlays on the lanes of a map: the share of traffic that takes them, and bottlenecks."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

from hmrsim.drawing.canvas import PALETTE, Attributes, element, path, titled

if TYPE_CHECKING:
    from hmrsim.drawing.canvas import Frame
    from hmrsim.geometry import Point
    from hmrsim.world.model import World

_MIN_WIDTH: Final = 1.6
_MAX_WIDTH: Final = 8.0
_PER_MARK: Final = 1.2
_LEGEND_LINE: Final = ((0.0, 0.0), (18.0, 0.0))


@dataclass(frozen=True)
class Weak:
    """A bottleneck.

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
