"""The files of worlds: the shipped worlds, the search for a file by name, and the options for reading."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Literal

from hmrsim.diagnostics import instead, meant
from hmrsim.errors import Problem, WorldError, reason_of
from hmrsim.world.model import ROS_NAME

_PACKAGE = Path(__file__).resolve().parents[1]


def folder(kind: str) -> Path:
    """Return the folder of the shipped ``maps`` or ``schemas``, in a wheel or in a source checkout."""
    installed = _PACKAGE / "data" / kind
    return installed if installed.is_dir() else _PACKAGE.parent / kind


def shipped_maps() -> dict[str, Path]:
    """Return the shipped worlds by bare name, such as ``hospital`` and ``zoo/crossing``, in order of name."""
    return dict(_maps_in(folder("maps")))


@cache
def _maps_in(maps: Path) -> dict[str, Path]:
    found = {path.relative_to(maps).with_suffix("").as_posix(): path for path in maps.rglob("*.yaml")}
    return dict(sorted(found.items()))


def find(source: str | Path) -> Path:
    """Return the file of a source: a path, or the bare name of a shipped world.

    Raises:
        WorldError: No such file exists, and no shipped world has this name.
    """
    path = Path(source)
    name = str(source)
    if not name:
        raise _error("", "the name of the world is empty; expected a file, or the name of a shipped world")
    try:
        if path.is_file():
            return path
    except OSError as error:  # of a name that is too long
        raise _error(name, f"can't be read: {reason_of(error)}") from None
    shipped = shipped_maps()
    if name in shipped and isinstance(source, str):
        return shipped[name]
    bare = isinstance(source, str) and not path.suffix and (path.name == name or meant(name, shipped) is not None)
    if bare and not path.exists():
        raise _error(name, f"no such file, and no shipped world of that name{instead(name, shipped)}")
    if path.stem in shipped and not path.exists():
        raise _error(name, f"no such file; the shipped world is called {path.stem!r}")
    return path


def _error(file: str, message: str) -> WorldError:
    return WorldError([Problem(file, "", message)])


@dataclass(frozen=True)
class ReadOptions:
    """Options for reading files, such as the page of a drawing.

    Attributes:
        page: The page of a drawing, the level of a building or the layout of a LIF file, by its name or its number
            from 1; None for the first page, and for all levels and layouts.
        rename: New names of the robots of drawings and buildings, by the names that they have there.
        lenient: Whether objects of unknown types are left out instead of being errors.
        neighbours: The number of neighbors of a grid's cell, 4 or 8; None for 8.
    """

    page: str | None = None
    rename: Mapping[str, str] = field(default_factory=lambda: MappingProxyType({}))
    lenient: bool = False
    neighbours: Literal[4, 8] | None = None


AS_IT_IS = ReadOptions()
"""The default options."""


def renames(texts: Iterable[str]) -> dict[str, str]:
    """Return the renamings of ``--rename OLD=NEW``.

    Raises:
        WorldError: A text is not as expected.
    """
    found: dict[str, str] = {}
    problems = []
    for text in texts:
        old, equals, new = text.rpartition("=")
        if not equals or not old or not re.fullmatch(ROS_NAME, new):
            message = "expected OLD=NEW, with a new name of letters, digits and _ such as wall_e"
            problems.append(Problem(f"--rename {text}", "", message))
        elif old in found:
            problems.append(Problem(f"--rename {text}", "", f"{old!r} is renamed to {found[old]!r} already"))
        else:
            found[old] = new
    if problems:
        raise WorldError(problems)
    return found
