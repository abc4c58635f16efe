"""World files that can be read: one format a file.

Whatever loads a world finds its format here, by the name of the file.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

from hmrsim.plugins import discover

if TYPE_CHECKING:
    from hmrsim.diagnostics import Finding, Path
    from hmrsim.world.options import ReadOptions


@dataclass(frozen=True)
class Document:
    """The content of a file.

    Attributes:
        data: The top-level keys of a world, as in a native file; they are validated later. A grid's lanes may be
            `hmrsim.world.pairs.Pairs`, which are not.
        line: Returns the line of a path in *data*, as precisely as it is known.
        findings: The errors and warnings of the reader.
        complete: Whether all names of the file are in *data*, so that a missing name is an error.
        pages: The names of its pages, levels or layouts; none if the format has none.
        robots: The names of its robots before renaming; none if the format has no renaming.
        grid: Whether it is a grid, whose cells have neighbours.
    """

    data: dict[str, Any]
    line: Callable[[Path], int | None] = lambda _path: None
    findings: tuple[Finding, ...] = ()
    complete: bool = True
    pages: tuple[str, ...] = ()
    robots: tuple[str, ...] = ()
    grid: bool = False


@dataclass(frozen=True)
class Format:
    """A file format.

    Attributes:
        name: Its name, which is that of its module.
        suffixes: The suffixes of such files; of two that fit, the longer one decides.
        matches: Returns whether a text has this format.
        read: Makes a document of the text, as the options say. The second argument is the name of the file, for
            the :class:`~hmrsim.errors.WorldError` that it raises when there is nothing to read at all.
        general: Whether files of other formats look like it, too, so that those come first.
    """

    name: str
    suffixes: tuple[str, ...]
    matches: Callable[[str], bool]
    read: Callable[[str, str, ReadOptions], Document]
    general: bool = False


@cache
def registry() -> dict[str, Format]:
    """Return all formats by name."""
    return discover(sys.modules[__name__], "FORMAT", Format)


def choose(name: str, text: str) -> Format | None:
    """Return the format of a file, by the end of its *name* and by its content; None for none.

    The content decides, and the suffix decides between two formats that fit.
    A general format is used for files that match no other.
    """
    by_suffix = sorted(
        ((len(suffix), kind) for kind in registry().values() for suffix in kind.suffixes if _ends(name, suffix)),
        key=lambda found: (-found[0], found[1].name),
    )
    candidates = [kind for _, kind in by_suffix]
    fits = [kind for kind in [*candidates, *registry().values()] if kind.matches(text)]
    return min(fits, key=lambda kind: kind.general, default=candidates[0] if candidates else None)


def _ends(name: str, suffix: str) -> bool:
    return name.lower().endswith(suffix)
