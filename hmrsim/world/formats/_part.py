"""Values of a file, each with its location."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from hmrsim.diagnostics import Path, shown

_MAX_NAME = 100
"""Maximum characters of a name."""

_MAX_NUMBER = 1e15
"""Maximum magnitude of a number; the world's own checks are stricter."""


class BadPart(Exception):
    """A value is invalid."""

    def __init__(self, part: Part, message: str) -> None:
        super().__init__(message)
        self.part = part


@dataclass(frozen=True, slots=True)
class Part:
    """A value, and the keys and indices that lead to it.

    A method that reads it raises `BadPart` if the value is not of the kind that the method returns.
    """

    value: Any
    path: Path = ()

    def expected(self, what: str) -> BadPart:
        """Return the error that this is not the expected value."""
        return BadPart(self, f"expected {what}, got {shown(self.value)}")

    def get(self, key: str) -> Part | None:
        """Return a part of a mapping; None if it isn't there, or null."""
        if not isinstance(self.value, dict):
            raise self.expected("a mapping")
        value = self.value.get(key)
        return None if value is None else Part(value, (*self.path, key))

    def want(self, key: str) -> Part:
        """Return a part of a mapping that has to be there."""
        part = self.get(key)
        if part is None:
            raise BadPart(Part(None, (*self.path, key)), "is missing")
        return part

    def entries(self) -> Iterator[tuple[str, Part]]:
        """Yield the values of a mapping."""
        if not isinstance(self.value, dict):
            raise self.expected("a mapping")
        for name, value in self.value.items():
            yield name, Part(value, (*self.path, name))

    def parts(self, key: str) -> list[Part]:
        """Return the values of a list in this mapping; none if there is no such list.

        An empty mapping counts as an empty list, as some programs write it.
        """
        part = self.get(key)
        return part.all() if part is not None and part.value != {} else []

    def all(self) -> list[Part]:
        """Return the values of a list."""
        if not isinstance(self.value, list):
            raise self.expected("a list")
        return [Part(value, (*self.path, i)) for i, value in enumerate(self.value)]

    def number(self) -> float:
        """Return a finite number."""
        if isinstance(self.value, bool) or not isinstance(self.value, (int, float)):
            raise self.expected("a number")
        if not abs(self.value) <= _MAX_NUMBER:
            raise self.expected(f"a number of at most {_MAX_NUMBER:g}")
        return float(self.value)

    def whole(self) -> int:
        """Return a whole number."""
        number = self.number()
        if not number.is_integer():
            raise self.expected("a whole number")
        return int(number)

    def text(self) -> str:
        """Return text."""
        if not isinstance(self.value, str):
            raise self.expected("text")
        return self.value

    def name(self) -> str:
        """Return text that can be a name."""
        name = self.text()
        if not 0 < len(name) <= _MAX_NAME:
            raise self.expected(f"a name of 1 to {_MAX_NAME} characters")
        return name

    def point(self) -> complex:
        """Return the point that a list of numbers begins with: x, y."""
        if not isinstance(self.value, list) or len(self.value) < 2:  # noqa: PLR2004
            raise self.expected("[x, y]")
        x, y = self.all()[:2]
        return complex(x.number(), y.number())
