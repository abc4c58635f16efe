"""XML from strangers: no document types, so no entities; bounded in size and depth; with line numbers."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING
from xml.parsers import expat

if TYPE_CHECKING:
    from collections.abc import Iterator

MOST_ELEMENTS = 200_000

DEEPEST = 100
"""Elements inside each other."""


class Refused(Exception):
    """The text is no XML, or none that is read here.

    Attributes:
        line: Where, from 1.
    """

    def __init__(self, message: str, line: int | None) -> None:
        super().__init__(message)
        self.line = line


@dataclass
class Element:
    """An element: its tag, attributes, line, children and own text."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = field(default_factory=list)
    texts: list[str] = field(default_factory=list)

    @property
    def text(self) -> str:
        """All text before the first child."""
        return "".join(self.texts)

    def find(self, tag: str) -> Element | None:
        """Return the first child with this tag."""
        return next(self.all(tag), None)

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the children with this tag."""
        return (child for child in self.children if child.tag == tag)


def parse(text: str, *, line: int | None = None) -> Element:
    """Return the root element.

    Args:
        text: The XML.
        line: The line of all elements, for XML that is packed into one; None to count.

    Raises:
        Refused: It is no XML, has a document type, or exceeds a bound.
    """
    parser = expat.ParserCreate("utf-8")
    tree = _Tree(parser, line)
    parser.StartElementHandler = tree.start
    parser.EndElementHandler = tree.end
    parser.CharacterDataHandler = tree.characters
    parser.StartDoctypeDeclHandler = tree.doctype
    parser.buffer_text = True
    try:
        parser.Parse(text.encode("utf-8", "surrogatepass"), True)
    except expat.ExpatError as error:
        message = expat.errors.messages.get(error.code, "unknown error")
        raise Refused(f"is no XML: {message}", line or error.lineno) from None
    if tree.root is None:
        raise Refused("is empty", line)
    return tree.root


class _Tree:
    """What expat calls; it builds the tree."""

    def __init__(self, parser: expat.XMLParserType, line: int | None) -> None:
        self.root: Element | None = None
        self._parser = parser
        self._line = line
        self._open: list[Element] = []
        self._count = 0

    def _here(self) -> int:
        return self._line or self._parser.CurrentLineNumber

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > MOST_ELEMENTS:
            raise Refused(f"has more than {MOST_ELEMENTS} elements", self._here())
        if len(self._open) >= DEEPEST:
            raise Refused(f"is nested deeper than {DEEPEST}", self._here())
        element = Element(tag, attributes, self._here())
        if self._open:
            self._open[-1].children.append(element)
        else:
            self.root = element
        self._open.append(element)

    def end(self, _tag: str) -> None:
        self._open.pop()

    def characters(self, text: str) -> None:
        element = self._open[-1]
        if not element.children:
            element.texts.append(text)

    def doctype(self, *_: object) -> None:
        raise Refused("has a DOCTYPE, which maps don't need and attacks do; take it out", self._here())
