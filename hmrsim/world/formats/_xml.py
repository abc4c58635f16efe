"""The elements of a drawing's XML."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from hmrsim import safe_xml

MAX_ELEMENTS = 200_000


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

    def append(self, child: Element) -> None:
        """Take the next child."""
        self.children.append(child)

    def add_text(self, text: str) -> None:
        """Take a piece of text; what comes after a child is left out."""
        if not self.children:
            self.texts.append(text)

    def find(self, tag: str) -> Element | None:
        """Return the first child with this tag."""
        return next(self.all(tag), None)

    def all(self, tag: str) -> Iterator[Element]:
        """Yield the children with this tag."""
        return (child for child in self.children if child.tag == tag)


def parse(text: str, *, line: int | None = None) -> Element:
    """Return the root element.

    *line* is that of all elements, for XML that is packed into one; None to count.

    Raises:
        Refused: It is not valid XML, has a document type, or exceeds a bound.
    """
    data = text.encode("utf-8", "surrogatepass")
    return safe_xml.parse(
        data, Element, max_elements=MAX_ELEMENTS, encoding="utf-8", line=line, on_text=Element.add_text
    )
