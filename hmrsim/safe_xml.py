"""Untrusted XML: no document types, so no entities; bounded in size and depth; with line numbers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, Protocol, TypeVar
from xml.parsers import expat

MAX_DEPTH = 100
"""Elements inside each other."""


class Parent(Protocol):
    """An element that takes children."""

    def append(self, child: Any, /) -> None:
        """Append a child element."""


E = TypeVar("E", bound=Parent)


class XmlError(Exception):
    """The text is not valid XML, or exceeds a bound.

    Attributes:
        line: Where, from 1.
    """

    def __init__(self, message: str, line: int | None) -> None:
        super().__init__(message)
        self.line = line


def parse(
    data: bytes,
    make: Callable[[str, dict[str, str], int], E],
    *,
    max_elements: int,
    encoding: str | None = None,
    line: int | None = None,
    on_text: Callable[[E, str], None] | None = None,
) -> E:
    """Return the root element.

    Args:
        data: The XML.
        make: Returns an element with a tag and attributes, of a line.
        max_elements: How many elements there may be.
        encoding: Of the data; None for what the XML says itself.
        line: The line of all elements, for XML that is packed into one; None to count.
        on_text: Called with an element and a piece of the text in it.

    Raises:
        XmlError: It is not valid XML, has a document type, or exceeds a bound; *make* may raise it, too.
    """
    parser = expat.ParserCreate(encoding)
    tree = _Tree(parser, make, max_elements, line)
    parser.StartElementHandler = tree.start
    parser.EndElementHandler = tree.end
    parser.StartDoctypeDeclHandler = tree.doctype
    if on_text is not None:
        parser.buffer_text = True
        parser.CharacterDataHandler = lambda text: on_text(tree.open[-1], text)
    try:
        parser.Parse(data, True)
    except expat.ExpatError as error:
        raise XmlError(f"is not valid XML: {expat.ErrorString(error.code)}", line or error.lineno) from None
    except (LookupError, ValueError) as error:
        raise XmlError(f"is not valid XML: {error}", tree.here) from None
    if tree.root is None:
        raise XmlError("is empty", line)
    return tree.root


class _Tree(Generic[E]):
    """The handlers of expat, which build the tree."""

    def __init__(
        self,
        parser: expat.XMLParserType,
        make: Callable[[str, dict[str, str], int], E],
        max_elements: int,
        line: int | None,
    ) -> None:
        self.root: E | None = None
        self.open: list[E] = []
        self._parser = parser
        self._make = make
        self._max_elements = max_elements
        self._line = line
        self._count = 0

    @property
    def here(self) -> int:
        return self._line or self._parser.CurrentLineNumber

    def start(self, tag: str, attributes: dict[str, str]) -> None:
        self._count += 1
        if self._count > self._max_elements:
            raise XmlError(f"has more than {self._max_elements} elements", self.here)
        if len(self.open) >= MAX_DEPTH:
            raise XmlError(f"is nested deeper than {MAX_DEPTH}", self.here)
        element = self._make(tag, attributes, self.here)
        if self.open:
            self.open[-1].append(element)
        else:
            self.root = element
        self.open.append(element)

    def end(self, _tag: str) -> None:
        self.open.pop()

    def doctype(self, *_: object) -> None:
        raise XmlError("has a DOCTYPE, which is not needed and opens the door to attacks; take it out", self.here)
