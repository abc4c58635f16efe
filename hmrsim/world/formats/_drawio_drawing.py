"""A draw.io page that is being read: its cells with their positions, the entities read from them, and the errors.

Groups and layers offset cells. Rotating a group in the editor rotates and moves its children in the file, so they are
not rotated here; only a cell whose position is a share of a rotated shape rotates with it.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.diagnostics import Finding, Path, shown
from hmrsim.world.formats._drawio_cells import BadCell, Box, Cell, number, read_cells, style_number, turn

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.files import ReadOptions
    from hmrsim.world.formats._drawio_cells import Element


_Value = TypeVar("_Value")


class Drawing:
    """A page that is being read.

    Attributes:
        cells: All cells, in the order of the page.
        by_id: The cells that have an id.
        lines: The lines of cells, by the path of the entity read from them.
        walls: The solids, as in a world file.
        places: The named points, as in a world file.
        items: The items, as in a world file.
        robots: The robots, as in a world file.
        robot_of: The names of the robots, by the ids of their cells.
        renamable: The names of the robots in the drawing.
        roads: The cell and points of each road.
        ways: The paths of robots' scripts, by robot, each with its cell.
    """

    def __init__(self, model: Element, options: ReadOptions) -> None:
        self.options = options
        self.findings: list[Finding] = []
        self.lines: dict[Path, int] = {(): model.line}
        self.walls: list[dict[str, Any]] = []
        self.places: dict[str, Any] = {}
        self.items: dict[str, Any] = {}
        self.robots: dict[str, Any] = {}
        self.robot_of: dict[str, str] = {}
        self.renamable: list[str] = []
        self.roads: list[tuple[Cell, list[Point]]] = []
        self.ways: dict[str, list[tuple[Cell, list[Point]]]] = defaultdict(list)
        self.cells = list(read_cells(model))
        self.by_id: dict[str, Cell] = {}
        for cell in self.cells:
            if cell.id in self.by_id:
                self.complain(cell, "has an id that another cell has; draw.io gives every cell its own", cell.id)
            elif cell.id:
                self.by_id[cell.id] = cell
        _place_all(self)
        self._counts: dict[str, int] = defaultdict(int)
        self._taken = {cell.attributes.get("name", "") for cell in self.cells if cell.kind == "robot"} | {
            cell.attributes.get("tag", "") for cell in self.cells if cell.kind == "POI"
        }

    def line(self, path: Path) -> int | None:
        """Return the line of the cell that a field is from."""
        for length in range(len(path), -1, -1):
            if path[:length] in self.lines:
                return self.lines[path[:length]]
        return None

    def complain(self, cell: Cell, message: str, value: object = None) -> None:
        """Record an error of a cell."""
        cell.failed = True
        self.findings.append(Finding((cell.title,), message, value, line=cell.line))

    def warn(self, cell: Cell, message: str, value: object = None) -> None:
        """Record a warning about a cell."""
        self.findings.append(Finding((cell.title,), message, value, "warning", cell.line))

    def attempt(self, cell: Cell, read: Callable[[], _Value]) -> _Value | None:
        """Return the value that *read* reads from a cell; record the error if it fails."""
        try:
            return read()
        except BadCell as error:
            self.complain(cell, str(error), error.value)
            return None

    def name(self, cell: Cell, attribute: str, prefix: str) -> str:
        """Return the name of a robot or POI; unnamed ones are numbered from 1."""
        name = cell.attributes.get(attribute, "")
        while not name:
            self._counts[prefix] += 1
            numbered = f"{prefix}_{self._counts[prefix]}"
            name = "" if numbered in self._taken else numbered
        return name

    def keep(self, cell: Cell, key: str, name: str, fields: dict[str, Any]) -> None:
        """Add an entity, unless its cell has another error.

        Raises:
            BadCell: The name is taken.
        """
        entities = {"places": self.places, "items": self.items, "robots": self.robots}[key]
        if name in entities:
            raise BadCell(f"is another one named {name!r}; give it a name of its own", name)
        if cell.failed:
            return
        entities[name] = fields
        self.lines[key, name] = cell.line

    def end(self, cell: Cell, which: str) -> Cell | None:
        """Return the shape at the ``source`` or ``target`` of a line, or None if the line has none.

        Raises:
            BadCell: The shape is not on this page, or is not a shape.
        """
        identifier = cell.own.get(which, "")
        if not identifier:
            return None
        other = self.by_id.get(identifier)
        if other is None or not other.is_shape:
            raise BadCell(f"has the {which} {shown(identifier)}, which is not a shape on this page", identifier)
        return other


def _place_all(drawing: Drawing) -> None:
    """Set the origin of each cell and the box of each shape; cells that can't be placed become errors."""
    by_id = drawing.by_id
    placed: set[str] = set()
    for cell in drawing.cells:
        chain = [cell]
        met = {cell.id}
        while chain[-1].parent not in placed and (group := by_id.get(chain[-1].parent)) is not None:
            if group.id in met:
                drawing.complain(
                    cell, f"is in the group {group.id!r}, which is inside itself; take it out of there", group.id
                )
                placed.add(group.id)
            else:
                chain.append(group)
                met.add(group.id)
        for part in reversed(chain):
            parent = by_id.get(part.parent)
            part.failed = part.failed or (parent is not None and parent.failed)
            if not part.failed:
                _place(part, parent, drawing)
            placed.add(part.id)


def _place(cell: Cell, parent: Cell | None, drawing: Drawing) -> None:
    """Place a cell, after its group."""
    if parent is not None:
        cell.origin = (parent.box.x, parent.box.y) if parent.is_shape else parent.origin
    if cell.is_edge or cell.geometry is None:
        return
    readers = [partial(number, cell.geometry, key) for key in ("x", "y", "width", "height")]
    readers.append(partial(style_number, cell.style, "rotation"))
    x, y, width, height, rotation = (drawing.attempt(cell, read) or 0.0 for read in readers)
    if cell.failed:
        return
    if width < 0 or height < 0:
        drawing.complain(cell, f"has the size {width:g} x {height:g}; expected none below 0", min(width, height))
        return
    cell.box = Box(cell.origin[0] + x, cell.origin[1] + y, width, height, rotation)
    if cell.is_relative and parent is not None and parent.is_shape:
        cell.box = drawing.attempt(cell, partial(_on, parent.box, cell.box, cell.geometry)) or cell.box


def _on(outer: Box, inner: Box, geometry: Element) -> Box:
    """Return the box of a cell whose corner is given as shares of another cell's width and height."""
    offset = next((point for point in geometry.all("mxPoint") if point.attributes.get("as") == "offset"), None)
    dx, dy = (number(offset, "x"), number(offset, "y")) if offset else (0.0, 0.0)
    box = inner._replace(
        x=outer.x + number(geometry, "x") * outer.width + dx, y=outer.y + number(geometry, "y") * outer.height + dy
    )
    x, y = turn(box.middle, outer)
    return box._replace(x=x - box.width / 2, y=y - box.height / 2)
