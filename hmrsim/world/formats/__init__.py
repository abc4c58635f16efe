"""World files that can be read, one format per module.

The format of a file is found by its name and content.
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
    from hmrsim.world.files import ReadOptions


@dataclass(frozen=True)
class Document:
    """The content of a file.

    Attributes:
        data: The top-level keys of a world, as in a native file, which are validated later. The lanes of a grid can be
            `hmrsim.world.network.Pairs`, which are not validated.
        line: Returns the line of a path in *data*, as precisely as it is known.
        findings: The errors and warnings of the reader.
        complete: Whether all names of the file are in *data*, so that a missing name is an error.
        pages: The names of its pages, levels or layouts; none if the format has none.
        robots: The names of its robots before renaming; none if the format has no renaming.
        grid: Whether it is a grid, whose cells have neighbors.
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
    """A format of world files.

    Attributes:
        name: Its name, which is that of its module.
        suffixes: The suffixes of such files; of two that fit, the longer one decides.
        matches: Returns whether a text has this format.
        read: Returns the document of a text, read with the given options. The second argument is the name of the file,
            for the :class:`~hmrsim.errors.WorldError` that it raises if the text can't be read at all.
        general: Whether it also matches files of other formats, which then take precedence.
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
    """Return the format of a file by the end of its *name* and its content, or None if none matches.

    The content decides; if several formats match, the suffix decides between them. A general format is used for files
    that match no other.
    """
    by_suffix = sorted(
        ((len(suffix), kind) for kind in registry().values() for suffix in kind.suffixes if _ends(name, suffix)),
        key=lambda match: (-match[0], match[1].name),
    )
    candidates = [kind for _, kind in by_suffix]
    fits = [kind for kind in [*candidates, *registry().values()] if kind.matches(text)]
    return min(fits, key=lambda kind: kind.general, default=candidates[0] if candidates else None)


def _ends(name: str, suffix: str) -> bool:
    return name.lower().endswith(suffix)
