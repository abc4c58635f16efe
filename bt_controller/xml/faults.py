"""The mistakes in a file: one line for each, with its place."""

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
    """The place of an element in the files.

    Attributes:
        file: The file, as the user names it.
        line: The line, from 1; 0 for the whole file.
        name: The element's ``name``; empty if it has none.
    """

    file: str
    line: int
    tag: str = ""
    name: str = ""

    def __str__(self) -> str:
        """Return file and line."""
        return f"{self.file}:{self.line}" if self.line else self.file

    def says(self, text: str) -> str:
        """Return a message about the element as one line."""
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
        """The warnings; one line for each."""
        return tuple(self._warnings)

    def add(self, origin: Origin, text: str) -> None:
        """Add a mistake; duplicates count once.

        Raises:
            TreeError: There are too many to go on.
        """
        self._lines[origin.says(text)] = None
        if len(self._lines) >= MAX_FAULTS:
            raise TreeError("\n".join([*self._lines, f"stopped after {MAX_FAULTS} mistakes"]))

    def warn(self, origin: Origin, text: str) -> None:
        """Add a warning; only a limited number of them is kept."""
        if len(self._warnings) < MAX_FAULTS:
            self._warnings[origin.says(text)] = None

    def raise_any(self) -> None:
        """Raise an error if there are mistakes.

        Raises:
            TreeError: Something was; a line each.
        """
        if self._lines:
            raise TreeError("\n".join(self._lines))
