"""The roads of a draw.io page, as waypoints and lanes."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import Finding
from hmrsim.world.formats._roads import connect
from hmrsim.world.segments import SegmentGrid

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.formats._cells import Cell
    from hmrsim.world.formats._drawing import Drawing


_MAX_COMPARISONS = 1_000_000
"""Maximum number of checks against walls while roads are linked."""


def road(drawing: Drawing, cell: Cell) -> None:
    """Read a road: from the centre of the shape where it begins, along its points, to where it ends.

    Raises:
        BadCell: An end is not a shape, or a number makes no sense.
    """
    source, target = drawing.end(cell, "source"), drawing.end(cell, "target")
    if any(end is not None and end.failed for end in (source, target)):
        return
    points = [*([source.box.centre] if source else ()), *cell.points(), *([target.box.centre] if target else ())]
    if len(set(points)) < 2:  # noqa: PLR2004
        drawing.warn(cell, "has fewer than two points, so it is not a road")
        return
    drawing.roads.append((cell, points))


def network(drawing: Drawing) -> dict[str, Any]:
    """Return the waypoints and lanes that the roads make, as in a world file."""
    try:
        found = connect([points for _, points in drawing.roads], _clear(drawing))
    except ValueError as error:
        drawing.findings.append(Finding(("lanes",), str(error)))
        return {}
    names = _numbered(len(found.points), {*drawing.places, *drawing.robots})
    for name, (_, index) in zip(names, found.points, strict=True):
        drawing.lines["waypoints", name] = drawing.roads[index][0].line
    for i, (_, _, index) in enumerate(found.lanes):
        drawing.lines["lanes", i] = drawing.roads[index][0].line
    return {
        "waypoints": {name: list(point) for name, (point, _) in zip(names, found.points, strict=True)},
        "lanes": [[names[a], names[b]] for a, b, _ in found.lanes],
    }


def _clear(drawing: Drawing) -> Callable[[Point, Point], bool]:
    """Return a function that tells whether no wall stands between two points; it raises ValueError after too many."""
    outlined = [wall["solid"] for wall in drawing.walls]
    sides = [
        ((a[0], a[1]), (b[0], b[1]))
        for outline in outlined
        for a, b in zip(outline, [*outline[1:], outline[0]], strict=True)
    ]
    if not sides:
        return lambda _a, _b: True
    grid = cache(lambda: SegmentGrid(sides))

    def clear(a: Point, b: Point) -> bool:
        if grid().looked > _MAX_COMPARISONS:
            raise ValueError("too many roads near each other with too many walls between; connect the roads")
        return grid().first_crossing(a, b) is None

    return clear


def _numbered(count: int, taken: set[str]) -> list[str]:
    """Return the names n1, n2, …, without those that are *taken*."""
    names: list[str] = []
    n = 0
    while len(names) < count:
        n += 1
        if f"n{n}" not in taken:
            names.append(f"n{n}")
    return names
