"""A problem and its remedy."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final, Literal

_SHOWN: Final = 4
"""The number of names that a message lists."""


@dataclass(frozen=True)
class Problem:
    """A problem on the network.

    Attributes:
        kind: A machine-readable word, such as ``no_router``.
        severity: A ``warning`` may be intended.
    """

    kind: str
    text: str
    remedy: str
    severity: Literal["error", "warning"] = "error"


def first_few(names: Iterable[str]) -> str:
    """Return the first few names and the number of the others, as text."""
    every = list(names)
    shown = every if len(every) <= _SHOWN + 1 else every[:_SHOWN]
    more = len(every) - len(shown)
    return ", ".join(shown) + (f" and {more} more" if more else "")
