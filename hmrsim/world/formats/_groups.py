"""Where the cells of a draw.io page are: groups, and layers, place what is in them.

Turning a group in the editor turns and moves its children in the file, so nothing is left to turn here; only what
has its place as a share of a turned shape goes round with it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from hmrsim.world.formats._cells import BadCell, Box, Cell, number, style_number
from hmrsim.world.formats._shapes import turn

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping

    from hmrsim.geometry import Point
    from hmrsim.world.formats._xml import Element


def place(cells: Iterable[Cell], by_id: Mapping[str, Cell], complain: Callable[[Cell, str], None]) -> None:
    """Set the origin of each cell, and the box of each shape.

    Args:
        cells: The cells of a page.
        by_id: The same, by id.
        complain: Takes a cell that can't be placed, and why; what is in it fails without a word.
    """
    placed: set[str] = set()
    for cell in cells:
        chain = [cell]
        met = {cell.id}
        while chain[-1].parent not in placed and (group := by_id.get(chain[-1].parent)) is not None:
            if group.id in met:
                complain(cell, f"is in the group {group.id!r}, which is inside itself; take it out of there")
                placed.add(group.id)
            else:
                chain.append(group)
                met.add(group.id)
        for part in reversed(chain):
            parent = by_id.get(part.parent)
            part.failed = part.failed or (parent is not None and parent.failed)
            if not part.failed:
                _place(part, parent, complain)
            placed.add(part.id)


def _place(cell: Cell, parent: Cell | None, complain: Callable[[Cell, str], None]) -> None:
    """Place one cell; what it is in has been placed already."""
    if parent is not None:
        cell.origin = (parent.box.x, parent.box.y) if parent.is_shape else parent.origin
    if cell.is_edge or cell.geometry is None:
        return
    try:
        cell.box = _box(cell.geometry, cell.origin, style_number(cell.style, "rotation"))
        if cell.is_relative and parent is not None and parent.is_shape:
            cell.box = _on(parent.box, cell.box, cell.geometry)
    except BadCell as error:
        complain(cell, str(error))


def _box(geometry: Element, origin: Point, rotation: float) -> Box:
    x, y, width, height = (number(geometry, key) for key in ("x", "y", "width", "height"))
    if width < 0 or height < 0:
        raise BadCell(f"has the size {width:g} x {height:g}; expected none below 0")
    return Box(origin[0] + x, origin[1] + y, width, height, rotation)


def _on(outer: Box, inner: Box, geometry: Element) -> Box:
    """Return the box of a cell whose corner is at a share of another's width and height."""
    offset = next((point for point in geometry.all("mxPoint") if point.attributes.get("as") == "offset"), None)
    dx, dy = (number(offset, "x"), number(offset, "y")) if offset else (0.0, 0.0)
    box = inner._replace(
        x=outer.x + number(geometry, "x") * outer.width + dx, y=outer.y + number(geometry, "y") * outer.height + dy
    )
    x, y = turn(box.middle, outer)
    return box._replace(x=x - box.width / 2, y=y - box.height / 2)
