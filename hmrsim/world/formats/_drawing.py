"""A draw.io page while it is being read: its cells, the entities that they became, and the errors."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

from hmrsim.diagnostics import Finding, Path, shown
from hmrsim.world.formats._cells import BadCell, Cell, read_cells
from hmrsim.world.formats._groups import place

if TYPE_CHECKING:
    from hmrsim.geometry import Point
    from hmrsim.world.formats._xml import Element
    from hmrsim.world.options import ReadOptions

_Value = TypeVar("_Value")


class Drawing:
    """What the readers of the cells share.

    Attributes:
        cells: All cells, in the order of the page.
        by_id: Those that have an id.
        lines: The lines of cells, by the path of what they became.
        walls: The solids, as in a world file.
        places: The named points, likewise.
        items: What can be picked up, likewise.
        robots: The robots, likewise.
        robot_of: The names of the robots, by the ids of their cells.
        renamable: What the robots are called in the drawing.
        roads: Each road's cell and points.
        ways: The points that robots follow by themselves, by robot, each with its cell.
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
        place(self.cells, self.by_id, self.complain)
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
        """Return what *read* reads of a cell; if that fails remember why."""
        try:
            return read()
        except BadCell as error:
            self.complain(cell, str(error), error.value)
            return None

    def name(self, cell: Cell, attribute: str, prefix: str) -> str:
        """Return the name of a robot or POI; one that has none is numbered, from 1."""
        name = cell.attributes.get(attribute, "")
        while not name:
            self._counts[prefix] += 1
            numbered = f"{prefix}_{self._counts[prefix]}"
            name = "" if numbered in self._taken else numbered
        return name

    def keep(self, cell: Cell, key: str, name: str, fields: dict[str, Any]) -> None:
        """Add something that has a name of its own, unless something else is wrong with it.

        Raises:
            BadCell: It has not.
        """
        things = {"places": self.places, "items": self.items, "robots": self.robots}[key]
        if name in things:
            raise BadCell(f"is another one named {name!r}; give it a name of its own", name)
        if cell.failed:
            return
        things[name] = fields
        self.lines[key, name] = cell.line

    def end(self, cell: Cell, which: str) -> Cell | None:
        """Return the shape at the ``source`` or ``target`` of a line; None where there is none.

        Raises:
            BadCell: It is not on this page, or no shape.
        """
        identifier = cell.own.get(which, "")
        if not identifier:
            return None
        other = self.by_id.get(identifier)
        if other is None or not other.is_shape:
            raise BadCell(f"has the {which} {shown(identifier)}, which is not a shape on this page", identifier)
        return other
