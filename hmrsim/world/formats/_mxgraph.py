"""The container of draw.io files: pages, each plain or compressed."""

from __future__ import annotations

import base64
import binascii
import re
import zlib
from dataclasses import dataclass
from urllib.parse import unquote

from hmrsim.safe_xml import XmlError
from hmrsim.world.formats._pages import choose_page
from hmrsim.world.formats._xml import Element, parse

MAX_INFLATED = 32 * 1024 * 1024
"""Bytes that a packed diagram may unfold to."""

_SVG = re.compile(r"<(!DOCTYPE\s+)?svg[\s/>]")

_UNNAMED = "Window 1"
"""What the original calls a page without a name."""


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
        XmlError: It can't be unpacked.
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
