"""A world as a picture."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Final, Literal

from hmrsim.drawing import marks
from hmrsim.drawing.canvas import Canvas
from hmrsim.drawing.caption import caption
from hmrsim.drawing.frame import Frame
from hmrsim.drawing.lanes import lanes
from hmrsim.drawing.naming import names
from hmrsim.drawing.palette import PALETTE
from hmrsim.drawing.svg import Attributes, element, group, number, path, titled

if TYPE_CHECKING:
    from hmrsim.drawing.overlay import Overlay
    from hmrsim.world.model import World

FONTS: Final = "'DejaVu Sans', Verdana, 'Segoe UI', Roboto, Arial, sans-serif"
_MARGIN: Final = 16.0


class Drawing(Canvas):
    """A picture of a world in its initial state: the same world gives the same picture, byte for byte.

    It has no ids, styles or scripts, so that it can be embedded in a page.

    Args:
        theme: ``light`` or ``dark``.
        width: Of the picture, in pixels.
        names: Whether names are written, as far as there is room; things have them as titles, too.
        details: Whether speed limits and capacities are written beside lanes.
        legend: Whether there are a title, a scale bar and what the colours mean.
    """

    def __init__(
        self,
        world: World,
        theme: Literal["light", "dark"] = "light",
        *,
        width: float = 1200.0,
        names: bool = True,
        details: bool = False,
        legend: bool = True,
        overlay: Overlay | None = None,
    ) -> None:
        above = 48.0 if legend else _MARGIN
        frame = Frame.of(world, width - 2 * _MARGIN, left=_MARGIN, top=above)
        super().__init__(world, PALETTE[theme], frame, width=width, details=details)
        self._names = names
        self.overlay = overlay
        entries = overlay.legend(self.colours) if overlay else ()
        self._caption, below = caption(self, entries) if legend else ("", _MARGIN)
        self.size = width, math.ceil(above + self.frame.size[1] + below)

    def svg(
        self,
        lane_colours: Mapping[tuple[str, str], tuple[str, float]] | None = None,
        *,
        lane_notes: Mapping[tuple[str, str], str] | None = None,
    ) -> str:
        """Return the picture.

        Args:
            lane_colours: Colour and width in pixels of lanes that have some of their own, by the waypoints at their
                ends in the direction of travel; where both directions have one they are beside each other.
            lane_notes: What is shown of such lanes when they are pointed at.
        """
        width, height = self.size
        paper = element("rect", width=width, height=height, fill=self.colours["background"])
        strokes: Attributes = {"fill": "none", "stroke_linecap": "round", "stroke_linejoin": "round"}
        over, place = self.overlay, (self.world, self.frame, self.mark, self.colours)
        if over:
            lane_colours = {**over.looks(self.mark), **(lane_colours or {})}
            lane_notes = {**over.notes(), **(lane_notes or {})}
        drawn = lanes(self.world, self.frame, self.mark, self.colours, lane_colours or {}, lane_notes or {})
        layers = [
            titled(self.world.name),
            paper,
            self._floor(),
            group("solids", self._solids()),
            group("only-lanes", over.beneath(*place)) if over else "",
            group("lanes", drawn, **strokes),
            group("walls", self._walls(), **strokes, stroke=self.colours["wall"], stroke_width=2.5),
            group("doors", self._doors()),
            group("only-waypoints", over.above(*place)) if over else "",
            group("waypoints", self._waypoints()),
            group("lifts", self._lifts()),
            group("docks", self._docks()),
            group("places", self._places()),
            group("items", self._items()),
            group("robots", self._robots()),
            names(self) if self._names else "",
            self._caption,
        ]
        return element(
            "svg",
            "\n",
            "\n".join(layer for layer in layers if layer),
            "\n",
            xmlns="http://www.w3.org/2000/svg",
            viewBox=f"0 0 {number(width)} {number(height)}",
            width=width,
            height=height,
            role="img",
            aria_label=self.world.name,
            font_family=FONTS,
        )

    def _floor(self) -> str:
        (width, height), frame = self.frame.size, self.frame
        look: Attributes = {"fill": self.colours["floor"], "stroke": self.colours["line"]}
        return element("rect", class_="floor", x=frame.left, y=frame.top, width=width, height=height, **look)

    def _solids(self) -> Iterator[str]:
        look: Attributes = {"fill": self.colours["solid"], "stroke": self.colours["wall"], "stroke_width": 1}
        for wall in self.world.walls:
            if not isinstance(wall, tuple):
                yield element("path", d=path(map(self.frame.at, wall.solid), closed=True), **look)

    def _walls(self) -> Iterator[str]:
        for wall in self.world.walls:
            if isinstance(wall, tuple):
                yield element("path", d=path(map(self.frame.at, wall)))

    def _waypoints(self) -> Iterator[str]:
        for name, point in self.world.points.items():
            yield marks.waypoint(self.frame.at(point), self.mark, self.colours, titled(name))

    def _doors(self) -> Iterator[str]:
        for name, door in self.world.doors.items():
            yield marks.door(
                self.frame.at(door.at[0]), self.frame.at(door.at[1]), self.colours, titled(f"{name}, a door")
            )

    def _lifts(self) -> Iterator[str]:
        for name, lift in self.world.lifts.items():
            for stop in lift.stops:
                at = self.frame.at(self.world.points[stop])
                yield marks.lift(at, self.mark, self.colours, titled(f"{name}, a lift, at {stop}"))

    def _docks(self) -> Iterator[str]:
        for name, dock in self.world.docks.items():
            at = self.frame.at(self.world.dock_point(name))
            yield marks.dock(at, self.mark, self.colours, titled(f"{name}, {dock.type}"), charges=dock.charges)

    def _places(self) -> Iterator[str]:
        for name, place in self.world.places.items():
            yield marks.place(self.frame.at(place.at), self.mark, self.colours, titled(name))

    def _items(self) -> Iterator[str]:
        for name, item in self.world.items.items():
            at = self.frame.at(self.world.point(item.at))
            yield marks.item(at, self.mark, self.colours, titled(f"{name}, {item.weight:g} kg"))

    def _robots(self) -> Iterator[str]:
        for name, robot in self.world.robots.items():
            at, base = self.frame.at(self.world.point(robot.at)), self.world.robot_type(robot).base
            yield marks.robot(
                at,
                self.robot_radius(name),
                -robot.yaw if self.frame.up else robot.yaw,
                self.types[robot.type],
                self.colours,
                titled(f"{name}, {robot.type}"),
                flies=base.flies,
            )
