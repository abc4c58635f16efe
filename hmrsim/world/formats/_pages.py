"""Files that have pages, levels or layouts, of which one can be asked for."""

from __future__ import annotations

from collections.abc import Sequence

from hmrsim.errors import Problem, WorldError

_LISTED = 20


def choose_page(names: Sequence[str], wanted: str, file: str, *, noun: str = "page", line: int | None = None) -> int:
    """Return the index of the page that is wanted, by its name or its number from 1; a name goes before a number.

    Raises:
        WorldError: There is none; the text says which there are.
    """
    if wanted in names:
        return names.index(wanted)
    numbers = [str(i + 1) for i in range(len(names))]
    if wanted in numbers:
        return numbers.index(wanted)
    pages = ", ".join(f"{i} ({name[:40]})" for i, name in enumerate(names[:_LISTED], 1))
    more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
    raise WorldError([Problem(file, "", f"has no {noun} {wanted[:40]!r}; there are {pages}{more}", line)])
