"""The work of laying overlays over a world, which is limited: a client may send a hundred bytes that ask for much."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path

MAX_WORK: Final = 1_000_000
"""The lines that all overlays of a world repeat, the entries that patterns are compared with, and the values put."""

FLAW: Final = 200
"""What an error counts as: its text looks for similar names."""

_CHARACTERS: Final = 16
"""Characters of a text that count as one value."""

_COMPARED: Final = 1024
"""Characters of a pattern, times those of the keys, that count as one value: so many steps comparing may take."""


class TooMuchWorkError(Exception):
    """The overlays of a world ask for more than the limit.

    Attributes:
        path: Where an overlay asks for what exceeds it.
    """

    def __init__(self, path: Path) -> None:
        super().__init__(
            f"the overlays of a world ask for more than {MAX_WORK:,} changes in all, with every repetition, every entry"
            " that a pattern is compared with and every value that is put; repeat less, or write the values into the "
            "world itself"
        )
        self.path = path


class Work:
    """Counts the work of all overlays of a world."""

    def __init__(self) -> None:
        self._left = MAX_WORK

    def spend(self, amount: int, path: Path) -> None:
        """Count work that an overlay asks for at *path*, before it is done.

        Raises:
            TooMuchWorkError: It is more than is left.
        """
        self._left -= amount
        if self._left < 0:
            raise TooMuchWorkError(path)

    def compare(self, pattern: str, parts: dict[str, Any] | list[Any], path: Path) -> None:
        """Count the comparison of a pattern with the keys or indices of all entries.

        Raises:
            TooMuchWorkError: It is more than is left.
        """
        letters = sum(map(len, parts)) if isinstance(parts, dict) else 0
        self.spend(len(parts) + letters * len(pattern) // _COMPARED, path)

    def size(self, value: Any) -> int:
        """Return the number of values in a value; of a large one, any number beyond the work that is left."""
        size, parts = 0, [value]
        while parts and size <= self._left:
            part = parts.pop()
            size += 1
            if isinstance(part, dict):
                parts += part.values()
                size += sum(map(len, part)) // _CHARACTERS
            elif isinstance(part, list):
                parts += part
            elif isinstance(part, str):
                size += len(part) // _CHARACTERS
        return size
