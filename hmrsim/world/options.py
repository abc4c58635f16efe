"""The options for reading world files."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Literal

from hmrsim.errors import Problem, WorldError
from hmrsim.world.model import ROS_NAME


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
