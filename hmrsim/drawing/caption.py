"""The caption of a map: its name, its scale and its legend."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Final

from hmrsim.drawing import marks
from hmrsim.drawing.labels import shortened, width_of
from hmrsim.drawing.svg import Attributes, element, group, path, text_of

if TYPE_CHECKING:
    from hmrsim.drawing.canvas import Canvas

_SIZE: Final = 11.0
_TITLE: Final = 16.0
_LINE: Final = 22.0
_MARK: Final = 6.0
_SWATCH: Final = 26.0
_BETWEEN: Final = 18.0
_MAX_TYPES: Final = 12
_BAR: Final = 0.15
"""Share of the width that the scale bar takes at most."""


def caption(drawing: Canvas, more: Iterable[tuple[str, str]] = ()) -> tuple[str, float]:
    """Return title, scale bar and legend, and how much room there is to be below the map.

    *more* are marks, around (9, 0), and their meanings for the end of the legend.
    """
    left, right = 16.0, drawing.width - 16.0
    below = drawing.frame.top + drawing.frame.size[1]
    x, y, parts = left, below + _LINE, []
    for mark, text in [*_entries(drawing), *more]:
        width = _SWATCH + width_of(text, _SIZE)
        if x > left and x + width > right:
            x, y = left, y + _LINE
        parts += [
            f'<g transform="translate({x:.2f} {y:.2f})">{mark}</g>',
            element("text", text_of(text), x=x + _SWATCH, y=y + 4),
        ]
        x += width + _BETWEEN
    legend = group("legend", parts, fill=drawing.colours["ink"], font_size=_SIZE)
    return group("caption", [*_head(drawing, left, right), legend]), y - below + _LINE * 0.8


def _head(drawing: Canvas, left: float, right: float) -> Iterator[str]:
    world, colours, scale = drawing.world, drawing.colours, drawing.frame.scale
    bar = _round_length((right - left) * _BAR / scale)
    long = bar * scale
    ends = [(right - long, 26.0), (right - long, 30.0), (right, 30.0), (right, 26.0)]
    yield element("path", d=path(ends), fill="none", stroke=colours["muted"])
    look: Attributes = {"font_size": _SIZE, "fill": colours["muted"]}
    yield element("text", f"{bar:g} {world.units}", x=right - long / 2, y=20, text_anchor="middle", **look)
    room = right - left - long - _BETWEEN
    title = shortened(world.name, max(4, int(room / (_TITLE * 0.62))))
    yield element("text", text_of(title), x=left, y=30, fill=colours["ink"], font_size=_TITLE, font_weight="700")
    counted = ", ".join(
        f"{len(things)} {word if len(things) != 1 else word.removesuffix('s')}"
        for word, things in (("robots", world.robots), ("lanes", world.lanes), ("items", world.items))
        if things
    )
    behind = width_of(title, _TITLE) * 1.05 + _BETWEEN
    if counted and behind + width_of(counted, _SIZE) < room:
        yield element("text", counted, x=left + behind, y=30, **look)


def _round_length(most: float) -> float:
    """Return the greatest of 1, 2, 5, 10, … that is not more."""
    power = 10.0 ** math.floor(math.log10(most))
    return float(next(step for step in (5, 2, 1) if step * power <= most) * power)


def _entries(drawing: Canvas) -> Iterator[tuple[str, str]]:
    """Return mark and meaning of each kind in the map; marks are around (9, 0)."""
    world, colours, at = drawing.world, drawing.colours, (9.0, 0.0)
    types = list(drawing.types.items())
    flying = {robot.type for robot in world.robots.values() if world.robot_type(robot).base.flies}
    for name, look in types[:_MAX_TYPES]:
        yield marks.robot(at, 8.0, 0.0, look, colours, flies=name in flying), shortened(name)
    if len(types) > _MAX_TYPES:
        yield "", f"and {len(types) - _MAX_TYPES} more types"
    if world.items:
        yield marks.item(at, _MARK, colours), "item"
    if world.places:
        yield marks.place(at, _MARK, colours), "place"
    for charges, meaning in ((True, "charger"), (False, "dock")):
        if any(dock.charges is charges for dock in world.docks.values()):
            yield marks.dock(at, _MARK * 0.8, colours, charges=charges), meaning
    if world.doors:
        yield marks.door((0.0, 0.0), (18.0, 0.0), colours), "door"
    if world.lifts:
        yield marks.lift(at, _MARK, colours), "lift"
    yield from _lines(drawing)


def _lines(drawing: Canvas) -> Iterator[tuple[str, str]]:
    world, colours, ends = drawing.world, drawing.colours, ((0.0, 0.0), (18.0, 0.0))
    look: Attributes = {"stroke": colours["lane"], "stroke_width": 1.3, "fill": "none"}
    if any(not lane.one_way for lane in world.lanes):
        yield element("path", d=path(ends), **look), "lane"
    if any(lane.one_way for lane in world.lanes):
        yield element("path", d=path(ends) + marks.chevron(*ends, 6.0), **look), "one-way lane"
    if any(isinstance(wall, tuple) for wall in world.walls):
        yield element("path", d=path(ends), stroke=colours["wall"], stroke_width=2.5), "wall"
    if any(not isinstance(wall, tuple) for wall in world.walls):
        filled: Attributes = {"fill": colours["solid"], "stroke": colours["wall"], "stroke_width": 1}
        yield element("rect", x=2, y=-6, width=14, height=12, **filled), "solid"
