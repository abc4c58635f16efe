"""The draw.io maps of the original HMRSim, read cell by cell.

Pixels, y down, nothing is flipped. Every error is reported with its cell; a cell with an error is left out.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING

from hmrsim.diagnostics import Finding, instead, shown
from hmrsim.errors import Problem, WorldError
from hmrsim.safe_xml import XmlError
from hmrsim.world.files import AS_IT_IS, ReadOptions
from hmrsim.world.formats import Document, Format, _drawio_entities, _drawio_roads
from hmrsim.world.formats._drawio_cells import BadCell, Cell, number, read_page
from hmrsim.world.formats._drawio_drawing import Drawing

if TYPE_CHECKING:
    from hmrsim.world.formats._drawio_cells import Element

_PAGE = 500.0

_LOOKS = re.compile(r"\s*<(\?xml|mxfile|mxGraphModel|svg|!DOCTYPE|!--)")

_SHAPES: dict[str, Callable[[Drawing, Cell], None]] = {
    "robot": _drawio_entities.read_robot,
    "pickable": _drawio_entities.read_item,
    "POI": _drawio_entities.read_place,
}

_LINES: dict[str, Callable[[Drawing, Cell], None]] = {
    "map-path": _drawio_roads.road,
    "path": _drawio_entities.read_path,
}

_TYPES = (*_SHAPES, *_LINES, "debug")


def _read(text: str, file: str, options: ReadOptions = AS_IT_IS) -> Document:
    try:
        page = read_page(text, file, options.page)
        drawing = Drawing(page.model, options)
    except XmlError as error:
        raise WorldError([Problem(file, "", str(error), error.line)]) from None
    _read_cells(drawing)
    data = {
        "name": page.name[:100],
        "units": "px",
        "bounds": _bounds(drawing, page.model),
        **_drawio_roads.network(drawing),
        "walls": drawing.walls,
        "places": drawing.places,
        "items": drawing.items,
        "robots": drawing.robots,
    }
    return Document(
        data,
        drawing.line,
        tuple(drawing.findings),
        complete=not any(cell.failed for cell in drawing.cells),
        pages=page.all,
        robots=tuple(drawing.renamable),
    )


def _read_cells(drawing: Drawing) -> None:
    """Read the shapes, then the lines between them, which can precede them in the file."""
    _warn_of_hidden_layers(drawing)
    _warn_of_orphans(drawing)
    lines = [cell for cell in drawing.cells if cell.kind in _LINES]
    for cell in [*(cell for cell in drawing.cells if cell.kind not in _LINES), *lines]:
        # A robot can have other errors than its position, which are reported, too; other cells can't.
        if not cell.failed or cell.kind in _SHAPES:
            drawing.attempt(cell, partial(_read_cell, drawing, cell))
    _drawio_entities.add_paths_to_scripts(drawing)


def _read_cell(drawing: Drawing, cell: Cell) -> None:
    """Read a cell, if its shape fits its type.

    Raises:
        BadCell: The cell is invalid.
    """
    if cell.kind is None:
        _drawio_entities.read_obstacle(drawing, cell)
    elif cell.kind in (*_SHAPES, *_LINES) and cell.geometry is None and not cell.is_edge:
        raise BadCell("has no mxGeometry, so it is nowhere")
    elif cell.kind in _SHAPES:
        _check_shape(drawing, cell)
        _SHAPES[cell.kind](drawing, cell)
    elif cell.kind in _LINES:
        if not cell.is_edge:
            raise BadCell(f"is a shape; a {cell.kind} is a line")
        _LINES[cell.kind](drawing, cell)
    elif cell.kind != "debug":
        _unknown(drawing, cell)


def _check_shape(drawing: Drawing, cell: Cell) -> None:
    parent = drawing.by_id.get(cell.parent)
    if cell.is_edge:
        raise BadCell(f"is a line; a {cell.kind} is a shape")
    if parent is not None and parent.is_edge:
        raise BadCell(f"is a label of the line {shown(parent.id)}; put it on the page", parent.id)


def _unknown(drawing: Drawing, cell: Cell) -> None:
    """Report an object of unknown type."""
    what = f"has the unknown type {shown(cell.kind)}" if cell.kind else "has no type"
    if drawing.options.lenient:
        drawing.warn(cell, f"{what}; it is left out", cell.kind)
        return
    expected = instead(cell.kind, _TYPES) if cell.kind else f"; expected one of {', '.join(_TYPES)}"
    raise BadCell(f"{what}{expected}; --lenient leaves it out", cell.kind)


def _warn_of_hidden_layers(drawing: Drawing) -> None:
    hidden = [cell for cell in drawing.cells if cell.is_layer and cell.own.get("visible") == "0"]
    if hidden:
        more = f", as are {len(hidden) - 1} more" if len(hidden) > 1 else ""
        drawing.warn(hidden[0], f"is a hidden layer{more}; what is on it is read all the same")


def _warn_of_orphans(drawing: Drawing) -> None:
    for cell in drawing.cells:
        if cell.parent and cell.parent not in drawing.by_id:
            place = f"is in {shown(cell.parent)}, which is not a cell of this page; it is placed on the page itself"
            drawing.warn(cell, place, cell.parent)


def _bounds(drawing: Drawing, model: Element) -> list[float] | None:
    try:
        return [0.0, 0.0, number(model, "pageWidth", _PAGE), number(model, "pageHeight", _PAGE)]
    except BadCell as error:
        drawing.findings.append(Finding(("bounds",), str(error), error.value, line=model.line))
        return None


FORMAT = Format(name="drawio", suffixes=(".drawio", ".xml"), matches=lambda text: bool(_LOOKS.match(text)), read=_read)
