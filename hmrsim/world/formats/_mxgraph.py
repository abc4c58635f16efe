"""The container of draw.io files and the cells in it, before anybody asks what they mean."""

from __future__ import annotations

import base64
import binascii
import re
import zlib
from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from urllib.parse import unquote

from hmrsim.world.formats._xml import Element, Refused, parse
from hmrsim.world.model import FARTHEST

if TYPE_CHECKING:
    from collections.abc import Iterator

    from hmrsim.geometry import Point

MOST_INFLATED = 32 * 1024 * 1024
"""Bytes that a packed diagram may unfold to."""

_DEEPEST = 100
"""Groups inside each other."""

_NUMBER = re.compile(r"\s*[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]{1,3})?\s*")


class BadCell(Exception):
    """A cell that can't be understood; the text says why."""


@dataclass(frozen=True)
class Box:
    """A rectangle: its corner of least x and y before it is turned, and how far it is turned, clockwise."""

    x: float
    y: float
    width: float
    height: float
    rotation: float = 0.0

    @property
    def centre(self) -> Point:
        """The centre as the original has it: half the size, rounded down."""
        return (self.x + self.width // 2, self.y + self.height // 2)


@dataclass
class Cell:
    """A shape or a line.

    Attributes:
        id: By which lines refer to it.
        kind: The ``type`` of a typed object; None for a bare cell.
        attributes: Those of the typed object.
        style: Keys and values; a word alone has the value "".
        is_edge: Whether it is a line.
        source: Id of the cell where a line begins; "" for none.
        target: Id of the cell where it ends.
        parent: Id of the group or layer that it is in.
        geometry: Its ``mxGeometry``.
        line: Where it is in the file.
    """

    id: str
    kind: str | None
    attributes: dict[str, str]
    style: dict[str, str]
    is_edge: bool
    source: str
    target: str
    parent: str
    geometry: Element | None
    line: int
    offset: Point = field(default=(0.0, 0.0))

    @property
    def has_box(self) -> bool:
        """Whether it has a place of its own on the page."""
        return not self.is_edge and self.geometry is not None and self.geometry.attributes.get("relative") != "1"

    def box(self) -> Box:
        """Return where a shape is.

        Raises:
            BadCell: It is nowhere, or its numbers make no sense.
        """
        if self.geometry is None:
            raise BadCell("has no mxGeometry, so it is nowhere")
        x, y, width, height = (number(self.geometry, key) for key in ("x", "y", "width", "height"))
        if width < 0 or height < 0:
            raise BadCell(f"has the size {width:g} x {height:g}; expected none below 0")
        rotation = style_number(self.style, "rotation")
        return Box(x + self.offset[0], y + self.offset[1], width, height, rotation)

    def points(self) -> Iterator[Point]:
        """Yield the points of a line, without those of the shapes at its ends.

        Raises:
            BadCell: A number makes no sense.
        """
        if self.geometry is None:
            return
        named = {point.attributes.get("as", ""): point for point in self.geometry.all("mxPoint")}
        array = next((part for part in self.geometry.all("Array") if part.attributes.get("as") == "points"), None)
        way = [named.get("sourcePoint"), *(array.all("mxPoint") if array else ()), named.get("targetPoint")]
        for point in way:
            if point is not None:
                yield (number(point, "x") + self.offset[0], number(point, "y") + self.offset[1])


def number(element: Element, key: str, default: float = 0.0) -> float:
    """Return a number of an element, *default* when it is not there.

    Raises:
        BadCell: It is no number, or too large to be one of a map.
    """
    return default if key not in element.attributes else _number(element.attributes[key], key)


def style_number(style: dict[str, str], key: str) -> float:
    """Return a number of a style, 0 when it is not there.

    Raises:
        BadCell: It is no number.
    """
    return _number(style[key], key) if style.get(key) else 0.0


def _number(text: str, key: str) -> float:
    if not _NUMBER.fullmatch(text) or abs(float(text)) > FARTHEST:
        raise BadCell(f"{key} is {text[:40]!r}; expected a number of at most {FARTHEST:g}")
    return float(text)


def read_model(text: str) -> tuple[Element, str]:
    """Return the ``mxGraphModel`` of the first page, and the page's name.

    Raises:
        Refused: There is none, or it can't be unpacked.
    """
    root = parse(text)
    if root.tag == "mxGraphModel":
        return root, ""
    if root.tag != "mxfile":
        raise Refused(f"begins with <{root.tag[:40]}>; expected <mxfile> or <mxGraphModel>", root.line)
    diagram = root.find("diagram")
    if diagram is None:
        raise Refused("has no <diagram>, so there is no page to read", root.line)
    page = diagram if diagram.children else _unpack(diagram)
    model = page if page.tag == "mxGraphModel" else page.find("mxGraphModel")
    if model is None:
        raise Refused("has no <mxGraphModel> in its <diagram>", diagram.line)
    return model, diagram.attributes.get("name", "")


def _unpack(diagram: Element) -> Element:
    """Return what is in a compressed diagram: base64 of deflate of percent-encoded XML."""
    packed = "".join(diagram.text.split())
    if not packed:
        raise Refused("has an empty <diagram>", diagram.line)
    try:
        deflated = base64.b64decode(packed, validate=True)
    except (binascii.Error, ValueError):
        raise Refused("has a compressed <diagram> that is no base64", diagram.line) from None
    inflater = zlib.decompressobj(wbits=-15)
    try:
        content = inflater.decompress(deflated, MOST_INFLATED + 1)
    except zlib.error as error:
        raise Refused(f"has a compressed <diagram> that can't be inflated: {error}", diagram.line) from None
    if len(content) > MOST_INFLATED:
        message = f"has a compressed <diagram> of more than {MOST_INFLATED // 1024 // 1024} MiB"
        raise Refused(message, diagram.line)
    if not inflater.eof:
        raise Refused("has a compressed <diagram> that is cut off", diagram.line)
    try:
        return parse(unquote(content.decode("utf-8"), errors="strict"), line=diagram.line)
    except UnicodeDecodeError:
        raise Refused("has a compressed <diagram> that is not UTF-8", diagram.line) from None


def read_cells(model: Element) -> list[Cell]:
    """Return the cells of a page, in its order, each with the offset of the groups that it is in."""
    root = model.find("root")
    cells = [_cell(element) for element in root.children] if root else []
    found = [cell for cell in cells if cell is not None]
    by_id = {cell.id: cell for cell in found if cell.id}
    for cell in found:
        cell.offset = _offset(cell, by_id)
    return found


def _cell(element: Element) -> Cell | None:
    wrapped = element.tag in ("object", "UserObject")
    inner = element.find("mxCell") if wrapped else element
    if inner is None or inner.tag != "mxCell":
        return None
    outer = element.attributes if wrapped else {}
    # A UserObject without a type is only a shape with a link or a tooltip.
    kind = outer.get("type", "") if element.tag == "object" else outer.get("type")
    return Cell(
        id=(outer or inner.attributes).get("id", ""),
        kind=kind,
        attributes=outer,
        style=_style(inner.attributes.get("style", "")),
        is_edge=inner.attributes.get("edge") == "1",
        source=inner.attributes.get("source", ""),
        target=inner.attributes.get("target", ""),
        parent=inner.attributes.get("parent", ""),
        geometry=inner.find("mxGeometry"),
        line=element.line,
    )


def _style(text: str) -> dict[str, str]:
    pairs = (part.partition("=") for part in text.split(";"))
    return {key.strip(): value.strip() for key, _, value in pairs if key.strip()}


def _offset(cell: Cell, by_id: dict[str, Cell]) -> Point:
    """Return where the innermost group of a cell begins on the page."""
    x = y = 0.0
    seen = {cell.id}
    group = by_id.get(cell.parent)
    while group is not None and group.id not in seen and len(seen) <= _DEEPEST:
        seen.add(group.id)
        if group.has_box and group.geometry is not None:
            try:
                x, y = x + number(group.geometry, "x"), y + number(group.geometry, "y")
            except BadCell:
                break
        group = by_id.get(group.parent)
    return x, y
