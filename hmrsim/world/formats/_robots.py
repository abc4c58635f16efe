"""The robots of a draw.io page, and the routes of their scripts."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import shown
from hmrsim.world.formats import _components
from hmrsim.world.formats._cells import BadCell, read_number

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.formats._cells import Cell
    from hmrsim.world.formats._drawing import Drawing

_FRAMES = 60.0
"""Of the original, a second; old maps have speeds in px a frame."""


def robot(drawing: Drawing, cell: Cell) -> None:
    """Read a robot; all its errors are reported.

    Raises:
        BadCell: Its name is taken.
    """
    old = drawing.name(cell, "name", "robot")
    name = drawing.options.rename.get(old, old)
    drawing.renamable.append(old)
    drawing.robot_of[cell.id] = name
    fields: dict[str, Any] = {
        "at": list(cell.box.centre),
        "base": drawing.attempt(cell, partial(_base, cell)) or {},
        "components": {},
        "script": drawing.attempt(cell, partial(_components.script, cell.attributes)) or [],
    }
    for component, read in _components.READERS.items():
        settings = drawing.attempt(cell, partial(read, cell.attributes))
        if settings is not None:
            fields["components"][component] = settings
    for warning in _components.odd(cell.attributes):
        drawing.warn(cell, warning)
    if cell.attributes.get("movable", "true") != "true":
        movable = cell.attributes["movable"]
        drawing.warn(cell, f"movable is {shown(movable)}; robots can always move here", movable)
    if name != old and name in drawing.robots:
        raise BadCell(f"can't be renamed to {name!r}, which another robot is called", name)
    drawing.keep(cell, "robots", name, fields)


def _base(cell: Cell) -> dict[str, float]:
    base: dict[str, float] = {}
    if cell.box.width and cell.box.height:
        base["radius"] = max(cell.box.width, cell.box.height) / 2
    if "speed" in cell.attributes:
        text = cell.attributes["speed"]
        speed = read_number(text, "speed")
        if speed <= 0:
            raise BadCell(f"speed is {shown(text)}; expected a number above 0, in px a frame", text)
        base["speed"] = speed * _FRAMES
    return base


def way(drawing: Drawing, cell: Cell) -> None:
    """Read a way that the robot at its beginning follows by itself.

    Raises:
        BadCell: There is no robot, or a number makes no sense.
    """
    source = drawing.end(cell, "source")
    if source is None or source.kind != "robot":
        what = "no source" if source is None else f"the source {shown(source.id)}, which is not a robot"
        raise BadCell(f"has {what}; draw it from the robot that is to follow it", source and source.id)
    target = drawing.end(cell, "target")
    points = [*cell.points(), *([target.box.centre] if target else ())]
    if not points:
        drawing.warn(cell, "has no points, so there is nothing to follow")
    elif source.id in drawing.robot_of:
        drawing.ways[drawing.robot_of[source.id]].append((cell, points))


def follow_ways(drawing: Drawing) -> None:
    """Put the ways that robots follow before the other orders of their scripts."""
    for name, ways in drawing.ways.items():
        if name in drawing.robots:
            fields = drawing.robots[name]
            fields["script"] = [*(_order(points) for _, points in ways), *fields["script"]]
            drawing.lines |= {("robots", name, "script", i): cell.line for i, (cell, _) in enumerate(ways)}


def _order(points: list[Point]) -> str:
    """Return the order to follow these points, in as few digits as tell them exactly."""
    return f"Follow {' '.join(repr(value).removesuffix('.0') for point in points for value in point)}"
