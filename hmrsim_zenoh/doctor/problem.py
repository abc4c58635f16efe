"""What is wrong, and what to do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal

if TYPE_CHECKING:
    from collections.abc import Iterable

_SHOWN: Final = 4
"""Names of many that are shown."""


@dataclass(frozen=True)
class Problem:
    """One thing that is wrong.

    Attributes:
        kind: A word for programs, such as ``no_router``.
        text: What is wrong, in one line.
        remedy: What to do, likewise.
        severity: A ``warning`` is of what may be as it is meant to be.
    """

    kind: str
    text: str
    remedy: str
    severity: Literal["error", "warning"] = "error"


def some(names: Iterable[str]) -> str:
    """Return a few of many names, and how many more there are."""
    every = list(names)
    shown = every if len(every) <= _SHOWN + 1 else every[:_SHOWN]
    more = len(every) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")
