"""The draw.io maps of the original HMRSim: what the cells of a drawing mean.

Pixels, y down, nothing is flipped. Every mistake is told with the cell that it is in; a cell in error is left out.
"""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Any

from hmrsim.errors import Problem, WorldError
from hmrsim.world.finding import Finding, Path, instead, shown
from hmrsim.world.formats import Document, Format, _components
from hmrsim.world.formats._mxgraph import BadCell, Box, Cell, number, read_cells, read_model
from hmrsim.world.formats._roads import connect
from hmrsim.world.formats._shapes import outlines
from hmrsim.world.formats._xml import Element, Refused
from hmrsim.world.segments import SegmentGrid

if TYPE_CHECKING:
    from collections.abc import Callable

    from hmrsim.geometry import Point

_PAGE = 500.0

_LOOKS = re.compile(r"\s*<(\?xml|mxfile|mxGraphModel|!DOCTYPE|!--)")


def _read(text: str, file: str) -> Document:
    try:
        model, name = read_model(text)
    except Refused as error:
        raise WorldError([Problem(file, "", str(error), error.line)]) from None
    drawing = _Drawing(model, name)
    return Document(drawing.data, drawing.line, tuple(drawing.findings))


class _Drawing:
    """A page, being understood."""

    def __init__(self, model: Element, name: str) -> None:
        self.findings: list[Finding] = []
        self._lines: dict[Path, int] = {(): model.line}
        self._cells = read_cells(model)
        self._by_id: dict[str, Cell] = {}
        self._roads: list[tuple[Cell, list[Point]]] = []
        self._walls: list[dict[str, Any]] = []
        self._places: dict[str, Any] = {}
        self._items: dict[str, Any] = {}
        self._robots: dict[str, Any] = {}
        self._kinds: dict[str, Callable[[Cell], None]] = {
            "robot": self._robot,
            "pickable": self._pickable,
            "POI": self._poi,
            "map-path": self._map_path,
            "path": self._path,
            "debug": lambda _cell: None,
        }
        self._read_cells()
        network = self._network()
        self.data: dict[str, Any] = {
            "name": name[:100] or "Window 1",
            "units": "px",
            "bounds": self._bounds(model),
            **network,
            "walls": self._walls,
            "places": self._places,
            "items": self._items,
            "robots": self._robots,
        }

    def line(self, path: Path) -> int | None:
        """Return the line of the cell that a field is from."""
        for length in range(len(path), -1, -1):
            if path[:length] in self._lines:
                return self._lines[path[:length]]
        return None

    def _bounds(self, model: Element) -> list[float]:
        try:
            width, height = number(model, "pageWidth", _PAGE), number(model, "pageHeight", _PAGE)
        except BadCell as error:
            self.findings.append(Finding(("bounds",), str(error), line=model.line))
            return [-1e7, -1e7, 1e7, 1e7]
        return [0.0, 0.0, width, height]

    def _read_cells(self) -> None:
        for cell in self._cells:
            if cell.id in self._by_id:
                self._complain(cell, "has an id that another cell has; draw.io gives every cell its own")
            elif cell.id:
                self._by_id[cell.id] = cell
        self._unnamed = {"robot": 0, "POI": 0}
        self._taken = {cell.attributes.get("name", "") for cell in self._cells if cell.kind == "robot"} | {
            cell.attributes.get("tag", "") for cell in self._cells if cell.kind == "POI"
        }
        for cell in self._cells:
            try:
                self._read_cell(cell)
            except BadCell as error:
                self._complain(cell, str(error))

    def _read_cell(self, cell: Cell) -> None:
        if cell.kind is None:
            self._untyped(cell)
        elif cell.kind in self._kinds:
            self._kinds[cell.kind](cell)
        elif not cell.kind:
            raise BadCell(f"has no type; expected one of {', '.join(self._kinds)}")
        else:
            raise BadCell(f"has the unknown type {shown(cell.kind)}{instead(cell.kind, self._kinds)}")

    def _complain(self, cell: Cell, message: str, severity: str = "error") -> None:
        what = f"{cell.kind} cell" if cell.kind else "cell"
        path = (f"{what} {shown(cell.id)}",)
        self.findings.append(Finding(path, message, cell.id, severity, cell.line))

    def _warn(self, cell: Cell, message: str) -> None:
        self._complain(cell, message, "warning")

    # --- what stands there ----------------------------------------------------------------------------------------

    def _untyped(self, cell: Cell) -> None:
        if not cell.style or not cell.has_box or self._is_decoration(cell):
            return
        box = cell.box()
        if cell.style.get("shape") == "mxgraph.floorplan.wall":
            box = Box(box.x, box.y, box.width or 1.0, box.height or 1.0, box.rotation)
        if not box.width or not box.height:
            self._warn(cell, f"has the size {box.width:g} x {box.height:g}, so it is no obstacle")
            return
        for outline in outlines(box, cell.style):
            self._lines["walls", len(self._walls)] = cell.line
            self._walls.append({"solid": [list(point) for point in outline]})

    def _is_decoration(self, cell: Cell) -> bool:
        flags = {"text", "edgeLabel", "group"}
        parent = self._by_id.get(cell.parent)
        return (
            not flags.isdisjoint(cell.style)
            or cell.style.get("shape") == "text"
            or (parent is not None and parent.is_edge)
        )

    def _name(self, cell: Cell, attribute: str, prefix: str) -> str:
        """Return the name of a robot or POI; one that has none is numbered, from 1."""
        name = cell.attributes.get(attribute, "")
        while not name:
            self._unnamed[cell.kind or ""] += 1
            numbered = f"{prefix}_{self._unnamed[cell.kind or '']}"
            name = "" if numbered in self._taken else numbered
        return name

    def _keep(self, cell: Cell, key: str, things: dict[str, Any], name: str, fields: dict[str, Any]) -> None:
        if name in things:
            raise BadCell(f"is another one named {name!r}; give it a name of its own")
        things[name] = fields
        self._lines[key, name] = cell.line

    def _robot(self, cell: Cell) -> None:
        box = cell.box()
        fields: dict[str, Any] = {"at": list(box.centre), "components": _components.known(cell.attributes)}
        orders = _components.script(cell.attributes)
        if orders:
            fields["script"] = orders
        if box.width and box.height:
            fields["base"] = {"radius": max(box.width, box.height) / 2}
        for key in _components.others(cell.attributes):
            self._warn(cell, f"{key} is not known here and left out")
        self._keep(cell, "robots", self._robots, self._name(cell, "name", "robot"), fields)

    def _pickable(self, cell: Cell) -> None:
        name = cell.attributes.get("name", "")
        if not name:
            raise BadCell("has no name; items are picked up by it")
        weight = number(Element("", cell.attributes, cell.line), "weight")
        self._keep(cell, "items", self._items, name, {"at": list(cell.box().centre), "weight": weight})

    def _poi(self, cell: Cell) -> None:
        name = self._name(cell, "tag", "POI")
        self._keep(cell, "places", self._places, name, {"at": list(cell.box().centre)})

    # --- roads ----------------------------------------------------------------------------------------------------

    def _map_path(self, cell: Cell) -> None:
        points = [*self._end(cell, cell.source, "source"), *cell.points(), *self._end(cell, cell.target, "target")]
        if len(set(points)) < 2:  # noqa: PLR2004
            self._warn(cell, "has fewer than two points, so it is no road")
            return
        self._roads.append((cell, points))

    def _end(self, cell: Cell, identifier: str, which: str) -> list[Point]:
        if not identifier:
            return []
        other = self._by_id.get(identifier)
        if other is None or other.is_edge:
            raise BadCell(f"has the {which} {shown(identifier)}, which is no shape on this page")
        return [other.box().centre] if cell is not other else []

    def _path(self, cell: Cell) -> None:
        self._warn(cell, "is a way that a robot follows by itself, which is not known here and left out")

    def _network(self) -> dict[str, Any]:
        try:
            network = connect([points for _, points in self._roads], self._clear())
        except ValueError as error:
            self.findings.append(Finding(("lanes",), str(error)))
            return {}
        names = _numbered(len(network.points), {*self._places, *self._robots})
        self._lines |= {
            ("waypoints", name): self._roads[road][0].line
            for name, (_, road) in zip(names, network.points, strict=True)
        }
        self._lines |= {("lanes", i): self._roads[road][0].line for i, (_, _, road) in enumerate(network.lanes)}
        return {
            "waypoints": {name: list(point) for name, (point, _) in zip(names, network.points, strict=True)},
            "lanes": [[names[a], names[b]] for a, b, _ in network.lanes],
        }

    def _clear(self) -> Callable[[Point, Point], bool]:
        """Return what tells whether no wall stands between two points."""
        outlined = [wall["solid"] for wall in self._walls]
        sides = [
            ((a[0], a[1]), (b[0], b[1]))
            for outline in outlined
            for a, b in zip(outline, [*outline[1:], outline[0]], strict=True)
        ]
        if not sides:
            return lambda _a, _b: True
        grid = SegmentGrid(sides)
        return lambda a, b: grid.first_crossing(a, b) is None


def _numbered(count: int, taken: set[str]) -> list[str]:
    """Return the names n1, n2, …, without those that are *taken*."""
    names: list[str] = []
    n = 0
    while len(names) < count:
        n += 1
        if f"n{n}" not in taken:
            names.append(f"n{n}")
    return names


FORMAT = Format(
    name="drawio",
    suffixes=(".drawio", ".xml"),
    matches=lambda text: bool(_LOOKS.match(text)),
    read=_read,
)
