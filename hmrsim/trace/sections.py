"""The sections of a trace: simulated time begins anew in each, at its header."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from typing import Any, Final, NamedTuple

from pydantic_core import from_json

from hmrsim.diagnostics import shown
from hmrsim.errors import TraceError
from hmrsim.protocol.outputs import Restart

_MARK: Final = re.compile(r'"kind":\s*"header"')
"""What is in each header, and hardly in any other line."""
_LISTED: Final = 10
"""Sections that an error lists."""


_CAUSES: Final[Mapping[str, str]] = {
    Restart.RESET: "the simulation was reset",
    Restart.TIME_RESET: "time was reset, robots and items stayed where they were",
    Restart.STOPPED: "the simulation was stopped",
    Restart.WORLD_LOADED: "a world was loaded",
}


class Section(NamedTuple):
    """A section of a trace.

    Attributes:
        number: Counted from 1.
        line: The number of its first line.
        world: The name of its world.
    """

    number: int
    line: int
    world: str


def restart_text(cause: str) -> str:
    """Return in words why a section began; a cause that is not known says so itself, and that of the first is empty."""
    return _CAUSES.get(cause, cause)


def may_begin_section(line: str) -> bool:
    """Return whether a line looks like a header, before it is parsed."""
    return _MARK.search(line) is not None


def begins_section(line: str) -> bool:
    """Return whether a line is a header."""
    return _header(line) is not None


def sections_of(lines: Iterable[str]) -> list[Section]:
    """Return the sections of a trace; its lines have their ends, and one without is incomplete and left out."""
    found: list[Section] = []
    for i, line in enumerate(lines, 1):
        if line.endswith("\n") and (header := _header(line)) is not None:
            world = header.get("world")
            name = world.get("name") if isinstance(world, dict) else ""
            found.append(Section(len(found) + 1, i, name if isinstance(name, str) else ""))
    return found


def check_section(lines: Iterable[str], number: int) -> None:
    """Check that a trace has a section.

    Raises:
        TraceError: It has not, or is no trace.
    """
    there = sections_of(lines)
    if not there:
        raise TraceError("line 1: no header of a trace; expected a file that was written with --trace")
    if number > len(there):
        named = [f"{each.number} from line {each.line} on ({shown(each.world)})" for each in there[:_LISTED]]
        more = f" and {len(there) - _LISTED} more" if len(there) > _LISTED else ""
        raise TraceError(f"no section {number}; there {'is' if len(there) == 1 else 'are'} {', '.join(named)}{more}")


def _header(line: str) -> dict[str, Any] | None:
    """Return the fields of a header; None if the line is none."""
    if not may_begin_section(line):
        return None
    try:
        found = from_json(line, allow_inf_nan=False)
    except ValueError:
        return None
    # A goal's fields may say the same of themselves.
    return found if isinstance(found, dict) and found.get("kind") == "header" else None
