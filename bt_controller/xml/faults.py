"""What is wrong with a file: each mistake a line, with its place."""

from __future__ import annotations

from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Final

from bt_controller.trees import TreeError

if TYPE_CHECKING:
    from collections.abc import Collection

_MOST: Final = 50
"""How many are told at once: more help nobody, and looking for what could be meant takes its time."""

_LONGEST: Final = 400
_LISTED: Final = 12


@dataclass(frozen=True)
class Origin:
    """Where an element is in the files.

    Attributes:
        file: As the user would name it.
        line: Counted from 1; 0 for the whole file.
        tag: Of the element.
        name: Its ``name``; empty if it has none.
    """

    file: str
    line: int
    tag: str = ""
    name: str = ""

    def __str__(self) -> str:
        """Return file and line."""
        return f"{self.file}:{self.line}" if self.line else self.file

    def says(self, text: str) -> str:
        """Return what is to be said of the element as one line."""
        element = f" <{self.tag}>" if self.tag else ""
        name = f" {self.name!r}" if self.name and self.name != self.tag else ""
        line = " ".join(f"{self}:{element}{name}{':' if element else ''} {text}".splitlines())
        return line if len(line) <= _LONGEST else f"{line[:_LONGEST]}…"


class Faults:
    """The mistakes found so far."""

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}

    def add(self, origin: Origin, text: str) -> None:
        """Remember a mistake; one that was found already counts once.

        Raises:
            TreeError: There are too many to go on.
        """
        self._lines[origin.says(text)] = None
        if len(self._lines) >= _MOST:
            raise TreeError("\n".join([*self._lines, f"that is {_MOST} mistakes; there may be more"]))

    def raise_any(self) -> None:
        """Go on if nothing was found.

        Raises:
            TreeError: Something was; a line each.
        """
        if self._lines:
            raise TreeError("\n".join(self._lines))


def instead(wanted: str, known: Collection[str], *, verb: str = "there are") -> str:
    """Return what could be meant, or what there is, as the end of a message."""
    if meant := get_close_matches(wanted, known, n=1):
        return f"; did you mean {meant[0]!r}?"
    if not known:
        return ""
    listed = ", ".join(list(known)[:_LISTED])
    return f"; {verb} {listed}{', …' if len(known) > _LISTED else ''}"
