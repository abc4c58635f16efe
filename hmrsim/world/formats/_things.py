"""The obstacles, items and named points of a draw.io page."""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.world.formats._cells import BadCell, read_number
from hmrsim.world.formats._shapes import outlines, thickness

if TYPE_CHECKING:
    from hmrsim.world.formats._cells import Cell
    from hmrsim.world.formats._drawing import Drawing

_DECORATION = frozenset(("text", "edgeLabel", "group", "swimlane"))
"""Words in the styles of cells that are not obstacles: labels, and frames around other cells."""


def obstacle(drawing: Drawing, cell: Cell) -> None:
    """Read a bare cell: a shape that is not a decoration stops robots.

    Raises:
        BadCell: A number of its style makes no sense.
    """
    if cell.geometry is None and cell.own.get("vertex") == "1":
        drawing.warn(cell, "has no mxGeometry, so it is nowhere and left out")
    if not cell.is_shape or not cell.style or _is_decoration(drawing, cell):
        return
    box = cell.box
    if cell.style.get("shape") == "mxgraph.floorplan.wall":
        box = box._replace(width=box.width or 1.0, height=box.height or 1.0)
    if not box.width or not box.height:
        drawing.warn(cell, f"has the size {box.width:g} x {box.height:g}, so it is not an obstacle")
        return
    if (thick := thickness(cell.style)) > min(box.width, box.height):
        size = f"{box.width:g} x {box.height:g}"
        drawing.warn(cell, f"wallThickness is {thick:g}, more than its size of {size}, so it is solid", thick)
    for outline in outlines(box, cell.style):
        drawing.lines["walls", len(drawing.walls)] = cell.line
        drawing.walls.append({"solid": [list(point) for point in outline]})


def _is_decoration(drawing: Drawing, cell: Cell) -> bool:
    parent = drawing.by_id.get(cell.parent)
    shape = cell.style.get("shape", "")
    return (
        not _DECORATION.isdisjoint(cell.style)
        or shape in _DECORATION
        or (cell.style.get("container") == "1" and not shape.startswith("mxgraph.floorplan."))
        or (parent is not None and parent.is_edge)
    )


def pickable(drawing: Drawing, cell: Cell) -> None:
    """Read an item.

    Raises:
        BadCell: It has no name, or one that is taken, or a weight that is not a number.
    """
    name = cell.attributes.get("name", "")
    if not name:
        raise BadCell("has no name; items are picked up by it")
    weight = read_number(cell.attributes.get("weight", "0"), "weight")
    drawing.keep(cell, "items", name, {"at": list(cell.box.centre), "weight": weight})


def poi(drawing: Drawing, cell: Cell) -> None:
    """Read a named point.

    Raises:
        BadCell: Its name is taken.
    """
    drawing.keep(cell, "places", drawing.name(cell, "tag", "POI"), {"at": list(cell.box.centre)})
