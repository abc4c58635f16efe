"""The container of draw.io files: XML with pages, each plain or compressed."""

from __future__ import annotations

import base64
import binascii
import re
import zlib
from collections.abc import Iterator
from dataclasses import dataclass, field
from urllib.parse import unquote

from hmrsim import safe_xml
from hmrsim.safe_xml import XmlError
from hmrsim.world.formats._layouts import choose_page

MAX_ELEMENTS = 200_000
"""Maximum XML elements of a file."""


@dataclass
class Element:
    """An XML element."""

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
