"""A file of nested values, JSON or YAML, while it is being read: its values and its errors."""

from __future__ import annotations

import json
from collections.abc import Callable
from functools import cached_property
from typing import Any, NoReturn, TypeVar

from hmrsim.diagnostics import MAX_FINDINGS, Finding, Path, shown
from hmrsim.documents.yaml_text import Lines, Unreadable, as_yaml, line_of, read_yaml
from hmrsim.errors import Problem, WorldError
from hmrsim.world.formats import Document
from hmrsim.world.formats._part import BadPart, Part

_MAX_VALUES = 500_000
"""Values in a JSON file, more or less."""

_MAX_LINED = 50_000
"""Values of a JSON file whose lines are found for errors, which takes several times as long as to read it."""

_Value = TypeVar("_Value")


class Reading:
    """The state that the readers of the parts of a file share.

    Args:
        lines: Returns the lines of the values, if it can; called once, and only when a line is asked for.

    Attributes:
        failed: Whether a part could not be read.
    """

    def __init__(self, value: Any, lines: Callable[[], Lines | None]) -> None:
        self.root = Part(value)
        self.failed = False
        self._read_lines = lines
        self._findings: list[Finding] = []
        self._origins: dict[Path, Path] = {}
        self._left: dict[tuple[str, str], tuple[Part, int]] = {}

    @cached_property
    def _lines(self) -> Lines | None:
        return self._read_lines()

    def origin(self, path: Path, part: Part) -> None:
        """Record the part of the file that a field of the world is from."""
        self._origins[path] = part.path

    def line(self, path: Path) -> int | None:
        """Return the line of what a field of the world is from."""
        for length in range(len(path), -1, -1):
            if path[:length] in self._origins:
                return self._line_of(self._origins[path[:length]])
        return None

    def _line_of(self, path: Path) -> int | None:
        return line_of(self._lines, path) if self._lines else None

    def complain(self, part: Part, message: str) -> None:
        """Record an error of a part; findings beyond the maximum are dropped."""
        self.failed = True
        self._find(part, message, "error")

    def warn(self, part: Part, message: str) -> None:
        """Record a warning about a part."""
        self._find(part, message, "warning")

    def _find(self, part: Part, message: str, severity: str) -> None:
        if len(self._findings) <= MAX_FINDINGS:
            self._findings.append(Finding(part.path, message, part.value, severity, self._line_of(part.path)))

    def leave_out(self, what: str, part: Part, count: int = 1, *, done: str = "left out") -> None:
        """Record a part of the file that worlds do not have, and how it was handled; reported once for each kind."""
        first, before = self._left.get((what, done), (part, 0))
        self._left[what, done] = (first, before + count)

    def attempt(self, read_yaml: Callable[[], _Value | None]) -> _Value | None:
        """Return the value that *read* reads; if that fails record the error."""
        try:
            return read_yaml()
        except BadPart as error:
            self.complain(error.part, str(error))
            return None

    def document(self, data: dict[str, Any], *, pages: tuple[str, ...] = (), robots: tuple[str, ...] = ()) -> Document:
        """Return the document of the file."""
        for (what, done), (part, count) in self._left.items():
            self._find(part, f"{what}: {count} {done}", "warning")
        return Document(data, self.line, tuple(self._findings), not self.failed, pages, robots)


def of_json(text: str, file: str) -> Reading:
    """Return the values of a JSON file.

    Raises:
        WorldError: It is none, or too much of it.
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
    return _of_mapping(Reading(value, lambda: _lines_of(as_yaml(text)) if values <= _MAX_LINED else None), file)


def of_yaml(text: str, file: str) -> Reading:
    """Return the values of a YAML file.

    Raises:
        WorldError: It is none, or exceeds a bound.
    """
    try:
        value, lines, findings = read_yaml(text)
    except Unreadable as error:
        raise _refused(file, str(error), error.line) from None
    reading = Reading(value, lambda: lines)
    for finding in findings:
        reading.complain(Part(finding.value, finding.path), finding.message)
    return _of_mapping(reading, file)


def _of_mapping(reading: Reading, file: str) -> Reading:
    if not isinstance(reading.root.value, dict):
        raise _refused(file, f"expected a mapping, got {shown(reading.root.value)}", 1)
    return reading


def _lines_of(text: str) -> Lines | None:
    try:
        return read_yaml(text)[1]
    except Unreadable:
        return None


def _not_finite(text: str) -> NoReturn:
    raise ValueError(f"{text} is not a number")


def _refused(file: str, message: str, line: int | None = None) -> WorldError:
    return WorldError([Problem(file, "", message, line)])
