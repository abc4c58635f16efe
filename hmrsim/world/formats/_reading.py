"""The values and errors of a JSON or YAML file that is being converted, each with its location."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from typing import Any, NoReturn, TypeVar

from hmrsim.diagnostics import MAX_FINDINGS, Finding, Path, shown
from hmrsim.documents.document import no_line, parse_document
from hmrsim.documents.yaml_text import Lines, Unreadable, as_yaml, line_of, read_yaml
from hmrsim.errors import Problem, WorldError
from hmrsim.world.formats import Document

_MAX_NAME = 100
"""Maximum characters of a name."""

_MAX_NUMBER = 1e15
"""Maximum magnitude of a number; the world's own checks are stricter."""


class BadPart(Exception):
    """An invalid value of a file."""

    def __init__(self, part: Part, message: str) -> None:
        super().__init__(message)
        self.part = part


@dataclass(frozen=True, slots=True)
class Part:
    """A value with the keys and indices that lead to it.

    A method that reads it raises `BadPart` if the value is not of the kind that the method returns.
    """

    value: Any
    path: Path = ()

    def expected(self, what: str) -> BadPart:
        """Return the error for an unexpected value."""
        return BadPart(self, f"expected {what}, got {shown(self.value)}")

    def get(self, key: str) -> Part | None:
        """Return a part of a mapping, or None if it is missing or null."""
        if not isinstance(self.value, dict):
            raise self.expected("a mapping")
        value = self.value.get(key)
        return None if value is None else Part(value, (*self.path, key))

    def want(self, key: str) -> Part:
        """Return a required part of a mapping."""
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
        """Return the values of a list in this mapping, or an empty list if it is missing.

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
        """Return a text."""
        if not isinstance(self.value, str):
            raise self.expected("text")
        return self.value

    def name(self) -> str:
        """Return a text that can be a name."""
        name = self.text()
        if not 0 < len(name) <= _MAX_NAME:
            raise self.expected(f"a name of 1 to {_MAX_NAME} characters")
        return name

    def point(self) -> complex:
        """Return the point at the beginning of a list of numbers: x, y."""
        if not isinstance(self.value, list) or len(self.value) < 2:  # noqa: PLR2004
            raise self.expected("[x, y]")
        x, y = self.all()[:2]
        return complex(x.number(), y.number())


_MAX_VALUES = 500_000
"""Maximum values in a JSON file, approximately."""

_MAX_LINED = 50_000
"""Maximum values of a JSON file for which lines are found, which takes several times as long as reading it."""

_Value = TypeVar("_Value")


class Reading:
    """A file that is being converted.

    Args:
        value: The content of the file.
        line: Returns the line of a path in the file, if it is known; called only for errors.

    Attributes:
        failed: Whether a part could not be read.
    """

    def __init__(self, value: Any, line: Callable[[Path], int | None]) -> None:
        self.root = Part(value)
        self.failed = False
        self._line_in_file = line
        self._findings: list[Finding] = []
        self._origins: dict[Path, Path] = {}
        self._left: dict[tuple[str, str], tuple[Part, int]] = {}

    def origin(self, path: Path, part: Part) -> None:
        """Record the part of the file from which a field of the world was read."""
        self._origins[path] = part.path

    def line(self, path: Path) -> int | None:
        """Return the line from which a field of the world was read."""
        for length in range(len(path), -1, -1):
            if path[:length] in self._origins:
                return self._line_in_file(self._origins[path[:length]])
        return None

    def complain(self, part: Part, message: str) -> None:
        """Record an error of a part; findings beyond the maximum are dropped."""
        self.failed = True
        self._find(part, message, "error")

    def warn(self, part: Part, message: str) -> None:
        """Record a warning about a part."""
        self._find(part, message, "warning")

    def _find(self, part: Part, message: str, severity: str) -> None:
        if len(self._findings) <= MAX_FINDINGS:
            self._findings.append(Finding(part.path, message, part.value, severity, self._line_in_file(part.path)))

    def leave_out(self, what: str, part: Part, count: int = 1, *, done: str = "left out") -> None:
        """Record a part without an equivalent in worlds and its treatment; each kind is reported once."""
        first, before = self._left.get((what, done), (part, 0))
        self._left[what, done] = (first, before + count)

    def attempt(self, read: Callable[[], _Value | None]) -> _Value | None:
        """Return the value that *read* reads, or record the error."""
        try:
            return read()
        except BadPart as error:
            self.complain(error.part, str(error))
            return None

    def document(self, data: dict[str, Any], *, pages: tuple[str, ...] = (), robots: tuple[str, ...] = ()) -> Document:
        """Return the document of a world."""
        for (what, done), (part, count) in self._left.items():
            self._find(part, f"{what}: {count} {done}", "warning")
        return Document(data, self.line, tuple(self._findings), not self.failed, pages, robots)


def of_json(text: str, file: str) -> Reading:
    """Return the values of a JSON file.

    Raises:
        WorldError: The text is not JSON, not a mapping, or too large.
    """
    try:
        values = sum(map(text.count, ",[{"))
        if values > _MAX_VALUES:
            raise _refused(file, f"has more than {_MAX_VALUES} values")
        value = json.loads(text, parse_constant=_not_finite)
    except json.JSONDecodeError as error:
        message = f"is not valid JSON: {error.msg[:1].lower()}{error.msg[1:]}"
        raise _refused(file, message, error.lineno) from None
    except RecursionError:
        raise _refused(file, "is nested too deep") from None
    except ValueError as error:
        raise _refused(file, f"is not valid JSON: {error}") from None
    if not isinstance(value, dict):
        raise _refused(file, f"expected a mapping, got {shown(value)}", 1)
    return Reading(value, _line_in(text) if values <= _MAX_LINED else no_line)


def of_yaml(text: str, file: str) -> Reading:
    """Return the values of a YAML file.

    Raises:
        WorldError: The text is not YAML, not a mapping, or exceeds a bound.
    """
    document = parse_document(text, file, WorldError, "a mapping")
    reading = Reading(document.data, document.line)
    for finding in document.findings:
        reading.complain(Part(finding.value, finding.path), finding.message)
    return reading


def _line_in(text: str) -> Callable[[Path], int | None]:
    """Return a function that returns the line of a path in a JSON text; the first call reads the text again."""

    @cache
    def lines() -> Lines | None:
        try:
            return read_yaml(as_yaml(text))[1]
        except Unreadable:
            return None

    def line(path: Path) -> int | None:
        known = lines()
        return None if known is None else line_of(known, path)

    return line


def _not_finite(text: str) -> NoReturn:
    raise ValueError(f"{text} is not a number")


def _refused(file: str, message: str, line: int | None = None) -> WorldError:
    return WorldError([Problem(file, "", message, line)])
