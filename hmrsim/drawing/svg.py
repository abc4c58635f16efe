"""SVG as text: elements, paths, numbers and arbitrary strings."""

from __future__ import annotations

import re
from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING, Final, TypeAlias

if TYPE_CHECKING:
    from hmrsim.geometry import Point

Attributes: TypeAlias = "dict[str, str | float]"
"""The attributes of an element, by name."""

_NOT_XML: Final = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that XML documents must not contain, not even escaped."""


def text_of(text: str) -> str:
    """Return a string as the content of an element, or of an attribute."""
    return escape(_NOT_XML.sub("\ufffd", text))


def number(value: float) -> str:
    """Return a number with at most two decimals."""
    text = f"{value:.2f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def element(tag: str, *content: str, **attributes: str | float) -> str:
    """Return an element.

    Names of *attributes* have ``_`` for ``-``; an underscore at the end is dropped, as in ``class_``.
    """
    written = "".join(
        f' {key.rstrip("_").replace("_", "-")}="{text_of(value) if isinstance(value, str) else number(value)}"'
        for key, value in attributes.items()
    )
    return f"<{tag}{written}>{''.join(content)}</{tag}>" if content else f"<{tag}{written}/>"


def group(kind: str, parts: Iterable[str], **attributes: str | float) -> str:
    """Return a group of elements, one per line; empty without elements."""
    lines = "\n".join(parts)
    return element("g", f"\n{lines}\n", class_=kind, **attributes) if lines else ""


def titled(title: str) -> str:
    """Return the tooltip of an element."""
    return element("title", text_of(title))


def path(points: Iterable[Point], *, closed: bool = False) -> str:
    """Return the data of a path of straight lines."""
    steps = "L".join(f"{number(x)} {number(y)}" for x, y in points)
    return f"M{steps}{'Z' if closed else ''}"
