"""The cells of a draw.io page, before they are interpreted, and the container of draw.io files."""

from __future__ import annotations

import base64
import binascii
import html
import math
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import unquote

from hmrsim import safe_xml
from hmrsim.geometry import MAX_COORDINATE
from hmrsim.safe_xml import XmlError
from hmrsim.world.formats._layouts import choose_page

if TYPE_CHECKING:
    from hmrsim.geometry import Point


MAX_ELEMENTS = 200_000
"""Maximum XML elements of a file."""


@dataclass
class Element:
    """An XML element, with its line in the file."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """The text before the first child."""
        return "".join(self.texts)

    def append(self, child: Element) -> None:
        """Add a child."""
        self.children.append(child)

    def add_text(self, text: str) -> None:
        """Add a piece of text, unless it follows a child."""
        if not self.children:
            self.texts.append(text)

    def find(self, tag: str) -> Element | None:
        """Return the first child with this tag."""
        return next(self.all(tag), None)

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the children with this tag."""
        return (child for child in self.children if child.tag == tag)


def parse(text: str, *, line: int | None = None) -> Element:
    """Return the root element of an XML text.

    *line* is the line number of all elements, for XML that is packed into one line; None to count lines.

    Raises:
        XmlError: The text is not valid XML, has a document type, or exceeds a limit.
    """
    data = text.encode("utf-8", "surrogatepass")
    return safe_xml.parse(
        data, Element, max_elements=MAX_ELEMENTS, encoding="utf-8", line=line, on_text=Element.add_text
    )


MAX_INFLATED = 32 * 1024 * 1024
"""Maximum size of an unpacked diagram, in bytes."""

_SVG = re.compile(r"<(!DOCTYPE\s+)?svg[\s/>]")

_UNNAMED = "Window 1"
"""The name of a page without a name."""


@dataclass(frozen=True)
class Page:
    """A page of a drawing.

    Attributes:
        model: Its ``mxGraphModel``.
        all: The names of all pages of the file.
    """

    name: str
    model: Element
    all: tuple[str, ...]


def read_page(text: str, file: str, wanted: str | None) -> Page:
    """Return a page of a file.

    *wanted* is the page's name, or its number from 1; None for the first.

    Raises:
        XmlError: The file is no drawing, or can't be unpacked.
        WorldError: There is no such page.
    """
    start = text[:1000]
    if _SVG.search(start) and "<mx" not in start:
        raise XmlError("is an SVG picture; open it in draw.io and save it as .drawio", None)
    root = parse(text)
    if root.tag == "mxGraphModel":
        _choose([_UNNAMED], file, wanted, root)
        return Page(_UNNAMED, root, (_UNNAMED,))
    if root.tag != "mxfile":
        raise XmlError(f"begins with <{root.tag[:40]}>; expected <mxfile> or <mxGraphModel>", root.line)
    diagrams = list(root.all("diagram"))
    if not diagrams:
        raise XmlError("has no <diagram>, so there is no page to read", root.line)
    names = [diagram.attributes.get("name") or _UNNAMED for diagram in diagrams]
    index = _choose(names, file, wanted, root)
    return Page(names[index], _model(diagrams[index]), tuple(names))


def _choose(names: list[str], file: str, wanted: str | None, root: Element) -> int:
    return 0 if wanted is None else choose_page(names, wanted, file, line=root.line)


def _model(diagram: Element) -> Element:
    page = diagram if diagram.children else _unpack(diagram)
    model = page if page.tag == "mxGraphModel" else page.find("mxGraphModel")
    if model is None:
        raise XmlError("has no <mxGraphModel> in its <diagram>", diagram.line)
    return model


def _unpack(diagram: Element) -> Element:
    """Return the content of a compressed diagram: base64 of deflate of percent-encoded XML."""
    packed = "".join(diagram.text.split())
    if not packed:
        raise XmlError("has an empty <diagram>", diagram.line)
    try:
        deflated = base64.b64decode(packed, validate=True)
    except (binascii.Error, ValueError):
        raise XmlError("has a compressed <diagram> that is not valid base64", diagram.line) from None
    inflater = zlib.decompressobj(wbits=-15)
    try:
        content = inflater.decompress(deflated, MAX_INFLATED + 1)
    except zlib.error as error:
        raise XmlError(f"has a compressed <diagram> that can't be inflated: {error}", diagram.line) from None
    if len(content) > MAX_INFLATED:
        message = f"has a compressed <diagram> of more than {MAX_INFLATED // 1024 // 1024} MiB"
        raise XmlError(message, diagram.line)
    if not inflater.eof:
        raise XmlError("has a compressed <diagram> that is cut off", diagram.line)
    try:
        return parse(unquote(content.decode("utf-8"), errors="strict"), line=diagram.line)
    except UnicodeDecodeError:
        raise XmlError("has a compressed <diagram> that is not UTF-8", diagram.line) from None


_NUMBER = re.compile(r"\s*[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]{1,3})?\s*")

_TAG = re.compile(r"<[^<>]*>")

_LABEL = 1_000
"""Maximum characters of a label that are read."""

_SHOWN = 40


MAX_CELLS = 10_000
"""Maximum number of cells on a page."""


class BadCell(Exception):
    """A cell that can't be interpreted; the message gives the reason.

    Attributes:
        value: The invalid value; None if the problem has no particular value.
    """

    def __init__(self, message: str, value: object = None) -> None:
        super().__init__(message)
        self.value = value


class Box(NamedTuple):
    """A rectangle: its corner with the least x and y before rotation, and its clockwise rotation."""

    x: float
    y: float
    width: float
    height: float
    rotation: float = 0.0

    @property
    def center(self) -> Point:
        """The center as in the original: half the size, rounded down."""
        return (self.x + self.width // 2, self.y + self.height // 2)

    @property
    def middle(self) -> Point:
        """The exact center, about which it is rotated."""
        return (self.x + self.width / 2, self.y + self.height / 2)


_QUARTERS = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}
"""Exact cosine and sine of quarter turns."""

_NOWHERE = Box(0.0, 0.0, 0.0, 0.0)


@dataclass
class Cell:
    """A shape, a line or a layer.

    Attributes:
        id: The id by which lines and groups refer to it.
        kind: The ``type`` of an object, "" if it has none; None for a bare cell.
        label: Its text, which may be HTML.
        attributes: The attributes of the object.
        own: The attributes of the ``mxCell``.
        style: Keys and values; a word alone has the value "".
        geometry: Its ``mxGeometry``.
        line: Its line in the file.
        origin: The origin of its group on the page.
        box: The box of a shape on the page.
        failed: Whether it has an error that was reported.
    """

    id: str
    kind: str | None
    label: str
    attributes: dict[str, str]
    own: dict[str, str]
    style: dict[str, str]
    geometry: Element | None
    line: int
    origin: Point = (0.0, 0.0)
    box: Box = _NOWHERE
    failed: bool = False

    @property
    def is_edge(self) -> bool:
        """True if the cell is a line."""
        return self.own.get("edge") == "1"

    @property
    def is_shape(self) -> bool:
        """True if the cell is neither a line nor a layer."""
        return not self.is_edge and self.geometry is not None

    @property
    def is_layer(self) -> bool:
        """True if the cell only contains other cells."""
        return self.geometry is None and {"vertex", "edge"}.isdisjoint(self.own)

    @property
    def is_relative(self) -> bool:
        """True if the cell's position is a share of its parent, or if the cell is the label of its parent."""
        return self.geometry is not None and self.geometry.attributes.get("relative") == "1"

    @property
    def parent(self) -> str:
        """The id of its group or layer."""
        return self.own.get("parent", "")

    @property
    def title(self) -> str:
        """The name in errors: type, id and label."""
        words = " ".join(html.unescape(_TAG.sub(" ", html.unescape(self.label[:_LABEL]))).split())
        label = f" ({words if len(words) <= _SHOWN else words[: _SHOWN - 1] + '…'})" if words else ""
        return f"{f'{self.kind[:_SHOWN]} ' if self.kind else ''}cell {self.id[:_SHOWN]!r}{label}"

    def points(self) -> Iterator[Point]:
        """Yield the points of a line, except those of the shapes at its ends.

        Raises:
            BadCell: A number is invalid.
        """
        if self.geometry is None:
            return
        named = {point.attributes.get("as", ""): point for point in self.geometry.all("mxPoint")}
        array = next((part for part in self.geometry.all("Array") if part.attributes.get("as") == "points"), None)
        way = [named.get("sourcePoint"), *(array.all("mxPoint") if array else ()), named.get("targetPoint")]
        for point in way:
            if point is not None:
                yield (number(point, "x") + self.origin[0], number(point, "y") + self.origin[1])


def turn(point: Point, box: Box) -> Point:
    """Return a point of a box after the box was rotated about its center, clockwise if y points down."""
    degrees = box.rotation % 360
    angle = math.radians(degrees)
    cos, sin = _QUARTERS.get(degrees) or (math.cos(angle), math.sin(angle))
    x, y = box.middle
    dx, dy = point[0] - x, point[1] - y
    # Rounded, so that files mean the same wherever sine and cosine differ in their last digit.
    return (round(x + dx * cos - dy * sin, 6), round(y + dx * sin + dy * cos, 6))


def number(element: Element, key: str, default: float = 0.0) -> float:
    """Return a number of an element, *default* when it is not there.

    Raises:
        BadCell: It is not a number, or too large to be one of a map.
    """
    return default if key not in element.attributes else read_number(element.attributes[key], key)


def style_number(style: dict[str, str], key: str, default: float = 0.0) -> float:
    """Return a number of a style, *default* when it is not there.

    Raises:
        BadCell: It is not a number.
    """
    return read_number(style[key], key) if style.get(key) else default


def read_number(text: str, key: str) -> float:
    """Return the number that the attribute *key* holds.

    Raises:
        BadCell: It is not a number, or too large to be one of a map.
    """
    if not _NUMBER.fullmatch(text) or abs(float(text)) > MAX_COORDINATE:
        raise BadCell(f"{key} is {text[:_SHOWN]!r}; expected a number of at most {MAX_COORDINATE:g}", text)
    return float(text)


def read_cells(model: Element) -> Iterator[Cell]:
    """Yield the cells of a page, in its order.

    Raises:
        XmlError: They are too many.
    """
    root = model.find("root")
    if root and len(root.children) > MAX_CELLS:
        raise XmlError(f"has {len(root.children)} cells on a page; at most {MAX_CELLS}", root.line)
    for element in root.children if root else ():
        if element.tag == "mxCell":
            yield _cell(element, element, None, element.attributes.get("value", ""))
        elif element.tag in ("object", "UserObject"):
            kind, inner = element.attributes.get("type", ""), element.find("mxCell")
            drawn = inner or Element("mxCell", {}, element.line)
            cell = _cell(element, drawn, kind, element.attributes.get("label", ""))
            # A layer may have data, too, and needs no type.
            yield replace(cell, kind=None) if inner and cell.is_layer and not kind else cell


def _cell(element: Element, inner: Element, kind: str | None, label: str) -> Cell:
    return Cell(
        id=element.attributes.get("id") or inner.attributes.get("id", ""),
        kind=kind,
        label=label,
        attributes=element.attributes if element is not inner else {},
        own=inner.attributes,
        style=_style(inner.attributes.get("style", "")),
        geometry=inner.find("mxGeometry"),
        line=element.line,
    )


def _style(text: str) -> dict[str, str]:
    pairs = (part.partition("=") for part in text.split(";"))
    return {key.strip(): value.strip() for key, _, value in pairs if key.strip()}
