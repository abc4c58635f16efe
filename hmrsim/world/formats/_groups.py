"""The positions of the cells of a draw.io page, which groups and layers offset.

Rotating a group in the editor rotates and moves its children in the file, so they are not rotated here; only a cell
whose position is a share of a rotated shape rotates with it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import TYPE_CHECKING, Protocol

from hmrsim.world.formats._cells import BadCell, Box, Cell, number, style_number
from hmrsim.world.formats._shapes import turn

if TYPE_CHECKING:
    from hmrsim.world.formats._xml import Element


class _Complain(Protocol):
    def __call__(self, cell: Cell, message: str, value: object = None) -> None: ...


def place(cells: Iterable[Cell], by_id: Mapping[str, Cell], complain: _Complain) -> None:
    """Set the origin of each cell, and the box of each shape.

    *complain* is called with a cell that can't be placed, the reason, and the value; not for its children.
    """
    placed: set[str] = set()
    for cell in cells:
        chain = [cell]
        met = {cell.id}
        while chain[-1].parent not in placed and (group := by_id.get(chain[-1].parent)) is not None:
            if group.id in met:
                complain(cell, f"is in the group {group.id!r}, which is inside itself; take it out of there", group.id)
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


def _place(cell: Cell, parent: Cell | None, complain: _Complain) -> None:
    """Place one cell; what it is in has been placed already."""
    if parent is not None:
        cell.origin = (parent.box.x, parent.box.y) if parent.is_shape else parent.origin
    if cell.is_edge or cell.geometry is None:
        return
    numbers = _numbers(cell, cell.geometry, complain)
    if cell.failed:
        return
    x, y, width, height, rotation = numbers
    if width < 0 or height < 0:
        complain(cell, f"has the size {width:g} x {height:g}; expected none below 0", min(width, height))
        return
    cell.box = Box(cell.origin[0] + x, cell.origin[1] + y, width, height, rotation)
    if cell.is_relative and parent is not None and parent.is_shape:
        try:
            cell.box = _on(parent.box, cell.box, cell.geometry)
        except BadCell as error:
            complain(cell, str(error), error.value)


def _numbers(cell: Cell, geometry: Element, complain: _Complain) -> list[float]:
    """Return x, y, width, height and rotation, without those that are not numbers; each of these is a finding."""
    found: list[float] = []
    readers = [partial(number, geometry, key) for key in ("x", "y", "width", "height")]
    for read in (*readers, partial(style_number, cell.style, "rotation")):
        try:
            found.append(read())
        except BadCell as error:
            complain(cell, str(error), error.value)
    return found


def _on(outer: Box, inner: Box, geometry: Element) -> Box:
    """Return the box of a cell whose corner is at a share of another's width and height."""
    offset = next((point for point in geometry.all("mxPoint") if point.attributes.get("as") == "offset"), None)
    dx, dy = (number(offset, "x"), number(offset, "y")) if offset else (0.0, 0.0)
    box = inner._replace(
        x=outer.x + number(geometry, "x") * outer.width + dx, y=outer.y + number(geometry, "y") * outer.height + dy
    )
    x, y = turn(box.middle, outer)
    return box._replace(x=x - box.width / 2, y=y - box.height / 2)
