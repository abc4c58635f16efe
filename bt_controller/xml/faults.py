"""What is wrong with a file: each mistake a line, with its place."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from bt_controller.errors import TreeError
from hmrsim.diagnostics import shortened, shown

MAX_FAULTS: Final = 50
"""The largest number of mistakes in a message: more do not help, and each suggestion takes time to compute."""

_MAX_LINE: Final = 400


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
        element = f" <{shortened(self.tag)}>" if self.tag else ""
        name = f" {shown(self.name)}" if self.name and self.name != self.tag else ""
        line = " ".join(f"{self}:{element}{name}{':' if element else ''} {text}".splitlines())
        return line if len(line) <= _MAX_LINE else f"{line[:_MAX_LINE]}…"


class Faults:
    """The mistakes found so far."""

    def __init__(self) -> None:
        self._lines: dict[str, None] = {}
        self._warnings: dict[str, None] = {}

    @property
    def warnings(self) -> tuple[str, ...]:
        """What need not be wrong; a line each."""
        return tuple(self._warnings)

    def add(self, origin: Origin, text: str) -> None:
        """Remember a mistake; one that was found already counts once.

        Raises:
            TreeError: There are too many to go on.
        """
        self._lines[origin.says(text)] = None
        if len(self._lines) >= MAX_FAULTS:
            raise TreeError("\n".join([*self._lines, f"that is {MAX_FAULTS} mistakes; there may be more"]))

    def warn(self, origin: Origin, text: str) -> None:
        """Remember what need not be wrong; too many are not told."""
        if len(self._warnings) < MAX_FAULTS:
            self._warnings[origin.says(text)] = None

    def raise_any(self) -> None:
        """Go on if nothing was found.

        Raises:
            TreeError: Something was; a line each.
        """
        if self._lines:
            raise TreeError("\n".join(self._lines))
