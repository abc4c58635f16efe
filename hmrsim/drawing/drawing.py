"""The drawing of a world as SVG, with a caption of title, scale bar and legend."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Final, Literal

from hmrsim.drawing import marks
from hmrsim.drawing.canvas import PALETTE, Attributes, Canvas, Frame, element, group, number, path, text_of, titled
from hmrsim.drawing.labels import names, shortened, width_of
from hmrsim.drawing.marks import lanes

if TYPE_CHECKING:
    from hmrsim.drawing.marks import Overlay
    from hmrsim.world.model import World

FONTS: Final = "'DejaVu Sans', Verdana, 'Segoe UI', Roboto, Arial, sans-serif"
# Sizes of the caption, in pixels.
_MARGIN: Final = 16.0
_FONT_SIZE: Final = 11.0
_TITLE_SIZE: Final = 16.0
_LINE_HEIGHT: Final = 22.0
_MARK_SIZE: Final = 6.0
_SWATCH_WIDTH: Final = 26.0
_GAP: Final = 18.0

_MAX_TYPES: Final = 12
"""Maximum number of robot types in the legend."""
_MAX_BAR: Final = 0.15
"""Maximum width of the scale bar, as a share of the picture's width."""


class Drawing(Canvas):
    """A picture of a world in its initial state: the same world gives the same picture, byte for byte.

    It has no ids, styles or scripts, so that it can be embedded in a page.

    Args:
        theme: ``light`` or ``dark``.
        width: The width of the picture, in pixels.
        names: Whether names are shown where there is room; tooltips always show them.
        details: Whether speed limits and capacities are shown beside lanes.
        legend: Whether there are a title, a scale bar and a legend.
        overlay: Traffic and bottlenecks to show on the lanes.
        colors: Colors that replace those of the theme, by the same names.
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
        colors: Mapping[str, str] | None = None,
    ) -> None:
        above = 48.0 if legend else _MARGIN
        frame = Frame.of(world, width - 2 * _MARGIN, left=_MARGIN, top=above)
        super().__init__(world, colors or PALETTE[theme], frame, width=width, details=details)
        self._names = names
        self.overlay = overlay
        entries = overlay.legend(self.colors) if overlay else ()
        self._caption, below = _caption(self, entries) if legend else ("", _MARGIN)
        self.size = width, math.ceil(above + self.frame.size[1] + below)

    def svg(
        self,
        lane_colors: Mapping[tuple[str, str], tuple[str, float]] | None = None,
        *,
        lane_notes: Mapping[tuple[str, str], str] | None = None,
    ) -> str:
        """Return the picture as SVG.

        Args:
            lane_colors: The color, and the width in pixels, of single directions of lanes, by the waypoints at their
                start and end. The two directions of a lane are drawn side by side.
            lane_notes: The tooltips of these lanes.
        """
        width, height = self.size
        paper = element("rect", width=width, height=height, fill=self.colors["background"])
        strokes: Attributes = {"fill": "none", "stroke_linecap": "round", "stroke_linejoin": "round"}
        overlay, setting = self.overlay, (self.world, self.frame, self.mark, self.colors)
        if overlay:
            lane_colors = {**overlay.looks(self.mark), **(lane_colors or {})}
            lane_notes = {**overlay.notes(), **(lane_notes or {})}
        layers = [
            titled(self.world.name),
            paper,
            self._floor(),
            group("solids", self._solids()),
            group("only-lanes", overlay.beneath(*setting)) if overlay else "",
            group("lanes", lanes(*setting, lane_colors or {}, lane_notes or {}), **strokes),
            group("walls", self._walls(), **strokes, stroke=self.colors["wall"], stroke_width=2.5),
            group("doors", self._doors()),
            group("only-waypoints", overlay.above(*setting)) if overlay else "",
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
        look: Attributes = {"fill": self.colors["floor"], "stroke": self.colors["line"]}
        return element("rect", class_="floor", x=frame.left, y=frame.top, width=width, height=height, **look)

    def _solids(self) -> Iterator[str]:
        look: Attributes = {"fill": self.colors["solid"], "stroke": self.colors["wall"], "stroke_width": 1}
        for solid in self.world.solids:
            yield element("path", d=path(map(self.frame.at, solid), closed=True), **look)

    def _walls(self) -> Iterator[str]:
        for wall in self.world.polylines:
            yield element("path", d=path(map(self.frame.at, wall)))

    def _waypoints(self) -> Iterator[str]:
        for name, point in self.world.points.items():
            yield marks.waypoint(self.frame.at(point), self.mark, self.colors, titled(name))

    def _doors(self) -> Iterator[str]:
        for name, door in self.world.doors.items():
            yield marks.door(
                self.frame.at(door.at[0]), self.frame.at(door.at[1]), self.colors, titled(f"{name}, a door")
            )

    def _lifts(self) -> Iterator[str]:
        for name, lift in self.world.lifts.items():
            for stop in lift.stops:
                at = self.frame.at(self.world.points[stop])
                yield marks.lift(at, self.mark, self.colors, titled(f"{name}, a lift, at {stop}"))

    def _docks(self) -> Iterator[str]:
        for name, dock in self.world.docks.items():
            at = self.frame.at(self.world.dock_point(name))
            yield marks.dock(at, self.mark, self.colors, titled(f"{name}, {dock.type}"), charges=dock.charges)

    def _places(self) -> Iterator[str]:
        for name, place in self.world.places.items():
            yield marks.place(self.frame.at(place.at), self.mark, self.colors, titled(name))

    def _items(self) -> Iterator[str]:
        for name, item in self.world.items.items():
            at = self.frame.at(self.world.point(item.at))
            yield marks.item(at, self.mark, self.colors, titled(f"{name}, {item.weight:g} kg"))

    def _robots(self) -> Iterator[str]:
        for name, robot in self.world.robots.items():
            at, base = self.frame.at(self.world.point(robot.at)), self.world.robot_type(robot).base
            yield marks.robot(
                at,
                self.robot_radius(name),
                -robot.yaw if self.frame.up else robot.yaw,
                self.types[robot.type],
                self.colors,
                titled(f"{name}, {robot.type}"),
                flies=base.flies,
            )


def _caption(canvas: Canvas, more: Iterable[tuple[str, str]] = ()) -> tuple[str, float]:
    """Return the title, scale bar and legend, and the height that they need below the map.

    *more* has entries for the end of the legend: each is a mark, drawn around (9, 0), and its meaning.
    """
    left, right = _MARGIN, canvas.width - _MARGIN
    below = canvas.frame.top + canvas.frame.size[1]
    x, y, parts = left, below + _LINE_HEIGHT, []
    for mark, text in [*_entries(canvas), *more]:
        width = _SWATCH_WIDTH + width_of(text, _FONT_SIZE)
        if x > left and x + width > right:
            x, y = left, y + _LINE_HEIGHT
        parts += [
            f'<g transform="translate({x:.2f} {y:.2f})">{mark}</g>',
            element("text", text_of(text), x=x + _SWATCH_WIDTH, y=y + 4),
        ]
        x += width + _GAP
    legend = group("legend", parts, fill=canvas.colors["ink"], font_size=_FONT_SIZE)
    return group("caption", [*_head(canvas, left, right), legend]), y - below + _LINE_HEIGHT * 0.8


def _head(canvas: Canvas, left: float, right: float) -> Iterator[str]:
    """Yield the scale bar at the right, the title at the left, and the numbers of entities if there is room."""
    world, colors, scale = canvas.world, canvas.colors, canvas.frame.scale
    bar = _round_length((right - left) * _MAX_BAR / scale)
    long = bar * scale
    ends = [(right - long, 26.0), (right - long, 30.0), (right, 30.0), (right, 26.0)]
    yield element("path", d=path(ends), fill="none", stroke=colors["muted"])
    look: Attributes = {"font_size": _FONT_SIZE, "fill": colors["muted"]}
    yield element("text", f"{bar:g} {world.units}", x=right - long / 2, y=20, text_anchor="middle", **look)
    room = right - left - long - _GAP
    title = shortened(world.name, max(4, int(room / (_TITLE_SIZE * 0.62))))
    yield element("text", text_of(title), x=left, y=30, fill=colors["ink"], font_size=_TITLE_SIZE, font_weight="700")
    counted = ", ".join(
        f"{len(things)} {word if len(things) != 1 else word.removesuffix('s')}"
        for word, things in (("robots", world.robots), ("lanes", world.lanes), ("items", world.items))
        if things
    )
    title_width = width_of(title, _TITLE_SIZE) * 1.05 + _GAP
    if counted and title_width + width_of(counted, _FONT_SIZE) < room:
        yield element("text", counted, x=left + title_width, y=30, **look)


def _round_length(most: float) -> float:
    """Return the greatest number of the series 1, 2, 5, 10, 20, … up to a maximum."""
    power = 10.0 ** math.floor(math.log10(most))
    return float(next(step for step in (5, 2, 1) if step * power <= most) * power)


def _entries(canvas: Canvas) -> Iterator[tuple[str, str]]:
    """Yield the legend's entries for the kinds of entities on the map: a mark, drawn around (9, 0), and its meaning."""
    world, colors, at = canvas.world, canvas.colors, (9.0, 0.0)
    types = list(canvas.types.items())
    flying = {robot.type for robot in world.robots.values() if world.robot_type(robot).base.flies}
    for name, look in types[:_MAX_TYPES]:
        yield marks.robot(at, 8.0, 0.0, look, colors, flies=name in flying), shortened(name)
    if len(types) > _MAX_TYPES:
        yield "", f"and {len(types) - _MAX_TYPES} more types"
    if world.items:
        yield marks.item(at, _MARK_SIZE, colors), "item"
    if world.places:
        yield marks.place(at, _MARK_SIZE, colors), "place"
    for charges, meaning in ((True, "charger"), (False, "dock")):
        if any(dock.charges is charges for dock in world.docks.values()):
            yield marks.dock(at, _MARK_SIZE * 0.8, colors, charges=charges), meaning
    if world.doors:
        yield marks.door((0.0, 0.0), (18.0, 0.0), colors), "door"
    if world.lifts:
        yield marks.lift(at, _MARK_SIZE, colors), "lift"
    yield from _line_entries(canvas)


def _line_entries(canvas: Canvas) -> Iterator[tuple[str, str]]:
    """Yield the legend's entries for lanes, walls and solids."""
    world, colors, ends = canvas.world, canvas.colors, ((0.0, 0.0), (18.0, 0.0))
    look: Attributes = {"stroke": colors["lane"], "stroke_width": 1.3, "fill": "none"}
    if any(not lane.one_way for lane in world.lanes):
        yield element("path", d=path(ends), **look), "lane"
    if any(lane.one_way for lane in world.lanes):
        yield element("path", d=path(ends) + marks.chevron(*ends, 6.0), **look), "one-way lane"
    if world.polylines:
        yield element("path", d=path(ends), stroke=colors["wall"], stroke_width=2.5), "wall"
    if world.solids:
        filled: Attributes = {"fill": colors["solid"], "stroke": colors["wall"], "stroke_width": 1}
        yield element("rect", x=2, y=-6, width=14, height=12, **filled), "solid"
