"""YAML 1.2 with the line of every value, an error for duplicate keys, and bounds on the cost of hostile files."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Any, TypeAlias

import yaml

from hmrsim.diagnostics import Finding, Path, shown

MAX_NODES = 500_000
"""Maximum number of values in a file, with aliases expanded."""

MAX_DEPTH = 50
"""Maximum nesting of mappings and lists."""

_MAX_NUMBER = 40

_Loader: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)

_NULL = {"", "~", "null", "Null", "NULL"}
_BOOL = {"true": True, "True": True, "TRUE": True, "false": False, "False": False, "FALSE": False}
_INT = re.compile(r"[-+]?[0-9]+")
_OTHER_INT = re.compile(r"0o[0-7]+|0x[0-9a-fA-F]+")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_NOT_FINITE = re.compile(r"[-+]?\.(inf|Inf|INF)|\.(nan|NaN|NAN)")
_BEGINS_NUMBER = frozenset("+-.0123456789")
_TAG = "tag:yaml.org,2002:"
_MERGE = "<<"

Lines: TypeAlias = "int | tuple[int, dict[str, Lines] | list[Lines]]"
"""The line of a value; for a mapping or list, also the lines of its values."""


class Unreadable(Exception):
    """A text that is not valid YAML, or that exceeds a bound.

    Attributes:
        line: The line, from 1; None if it is unknown.
    """

    def __init__(self, message: str, line: int | None) -> None:
        super().__init__(message)
        self.line = line


@dataclass(slots=True)
class _Part:
    """A value that is being built.

    Attributes:
        size: The number of values in it, itself included, with aliases expanded.
        depth: The nesting of mappings and lists in it.
        anchor: The name by which aliases refer to it.
        key: The key whose value comes next, and its line.
    """

    value: Any
    lines: Lines
    size: int = 1
    depth: int = 0
    anchor: str | None = None
    key: tuple[str, int] | None = None
    path: Path = ()


def read_yaml(text: str) -> tuple[Any, Lines, list[Finding]]:
    """Return the value of a text, its lines, and its duplicate keys.

    Raises:
        Unreadable: The text is not valid YAML, has more than one document, or exceeds a bound.
    """
    try:
        builder = _Builder()
        for event in yaml.parse(text, Loader=_Loader):
            builder.take(event)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        # As of 6.0.4 PyYAML has a bound too, which its parser reaches first.
        deep = "nesting depth" in (error.problem or "")
        why = f"is nested deeper than {MAX_DEPTH}" if deep else f"is not valid YAML: {_problem(error, text)}"
        raise Unreadable(why, mark.line + 1 if mark else None) from None
    except yaml.YAMLError as error:
        raise Unreadable(f"is not valid YAML: {str(error).splitlines()[0]}", None) from None
    except UnicodeEncodeError as error:
        stray = error.object[error.start : error.end]
        raise Unreadable(f"has bytes that are no text in UTF-8: {stray!a}", None) from None
    if builder.root is None:
        raise Unreadable("is empty", None)
    return builder.root.value, builder.root.lines, builder.findings


def _problem(error: yaml.MarkedYAMLError, text: str) -> str:
    """Return the parser's message; for an unexpected character, name it and its column."""
    problem, mark = str(error.problem), error.problem_mark
    lines = text.split("\n")
    if mark is None or mark.line >= len(lines):
        return problem
    begin = lines[mark.line][: mark.column + 1]
    if begin.endswith("\t") or "tab character" in problem:
        column = len(begin) if begin.endswith("\t") else lines[mark.line].find("\t") + 1
        return f"there is a tab in column {column}; indent with spaces"
    if "cannot start any token" in problem:
        return f"{shown(begin[-1:])} in column {len(begin)} can't begin a value; put the value in quotes"
    return problem


def line_of(lines: Lines, path: Path) -> int:
    """Return the line of a path, or of the nearest part that should hold it."""
    for step in path:
        if isinstance(lines, int):
            return lines
        line, parts = lines
        try:
            lines = parts[step]  # type: ignore[index]
        except (LookupError, TypeError):
            return line
    return lines if isinstance(lines, int) else lines[0]


class _Builder:
    """Builds values from YAML events. Aliases share the value of their anchor, but count as copies."""

    def __init__(self) -> None:
        self.root: _Part | None = None
        self.findings: list[Finding] = []
        self._open: list[_Part] = []
        self._anchors: dict[str, _Part | None] = {}
        self._size = 0

    def take(self, event: Any) -> None:
        line = event.start_mark.line + 1
        if isinstance(event, yaml.ScalarEvent):
            self._scalar(event, line)
        elif isinstance(event, yaml.DocumentStartEvent) and self.root is not None:
            raise Unreadable("has more than one document; keep one", line)
        elif isinstance(event, (yaml.MappingStartEvent, yaml.SequenceStartEvent)):
            self._begin(event, line)
        elif isinstance(event, (yaml.MappingEndEvent, yaml.SequenceEndEvent)):
            part = self._open.pop()
            if part.anchor:
                self._anchors[part.anchor] = part
            self._add(part.value, part.lines, part.size, part.depth)
        elif isinstance(event, yaml.AliasEvent):
            self._alias(str(event.anchor), line)

    def _begin(self, event: Any, line: int) -> None:
        is_mapping = isinstance(event, yaml.MappingStartEvent)
        if event.tag not in (None, "!", _TAG + ("map" if is_mapping else "seq")):
            raise Unreadable(f"has the tag {event.tag!r}; leave it out", line)
        self._count(1, len(self._open) + 1, line)
        if self._open and self._wants_key():
            raise Unreadable("has a mapping or list as a key; use a name", line)
        value: Any = {} if is_mapping else []
        path = (*self._open[-1].path, self._step()) if self._open else ()
        parts: Any = {} if is_mapping else []
        begins = self._open[-1].key[1] if self._open and self._open[-1].key else line
        self._open.append(_Part(value, (begins, parts), 1, 1, event.anchor, path=path))
        if event.anchor:
            self._anchors[event.anchor] = None

    def _step(self) -> str | int:
        key = self._open[-1].key
        return key[0] if key else len(self._open[-1].value)

    def _wants_key(self) -> bool:
        return isinstance(self._open[-1].value, dict) and self._open[-1].key is None

    def _count(self, size: int, depth: int, line: int) -> None:
        self._size += size
        if self._size > MAX_NODES:
            raise Unreadable(f"has more than {MAX_NODES} values, aliases written out", line)
        if depth > MAX_DEPTH:
            raise Unreadable(f"is nested deeper than {MAX_DEPTH}", line)

    def _scalar(self, event: Any, line: int) -> None:
        self._count(1, 0, line)
        if self._open and self._wants_key():
            if event.value == _MERGE and event.implicit[0]:
                raise Unreadable(f"has the merge key {_MERGE}, which YAML 1.2 no longer has; write the keys out", line)
            self._open[-1].key = (event.value, line)
            return
        value = _resolve(event, line)
        if event.anchor:
            self._anchors[event.anchor] = _Part(value, line)
        self._add(value, line)

    def _alias(self, anchor: str, line: int) -> None:
        part = self._anchors.get(anchor)
        if part is None:
            why = "is inside what it stands for" if anchor in self._anchors else "stands for nothing"
            raise Unreadable(f"alias {shown(anchor)} {why}", line)
        self._count(part.size, len(self._open) + part.depth, line)
        if self._open and self._wants_key():
            if not isinstance(part.value, str):
                raise Unreadable(f"alias {shown(anchor)} is not a name that could be a key", line)
            self._open[-1].key = (part.value, line)
            return
        self._add(part.value, part.lines, part.size, part.depth)

    def _add(self, value: Any, lines: Lines, size: int = 1, depth: int = 0) -> None:
        """Add a finished value, with its lines, to the open mapping or list."""
        if not self._open:
            self.root = _Part(value, lines)
            return
        parent = self._open[-1]
        parent.size += size
        if depth >= parent.depth:
            parent.depth = depth + 1
        parts: Any = parent.lines[1] if isinstance(parent.lines, tuple) else ()
        if parent.key is None:
            parent.value.append(value)
            parts.append(lines)
            return
        key, line = parent.key
        parent.key = None
        if key in parent.value:
            first = line_of(parent.lines, (key,))
            message = f"key {shown(key)} is there twice, first in line {first}; keep one"
            self.findings.append(Finding((*parent.path, key), message, key, line=line))
            return
        parent.value[key] = value
        parts[key] = lines


def _resolve(event: Any, line: int) -> object:
    """Return the value of a scalar by YAML 1.2's core schema."""
    text: str = event.value
    if event.tag is not None and event.tag != "!":
        if event.tag == f"{_TAG}str":
            return text
        raise Unreadable(f"has the tag {shown(event.tag)}; leave it out", line)
    return plain(text) if event.implicit[0] else text


def plain(text: str) -> object:
    """Return the value of a scalar without quotes."""
    value: object = text
    if text in _NULL:
        value = None
    elif text in _BOOL:
        value = _BOOL[text]
    elif text[0] not in _BEGINS_NUMBER:
        value = text
    elif _INT.fullmatch(text):
        value = int(text) if len(text) <= _MAX_NUMBER else float(text)
    elif _FLOAT.fullmatch(text):
        value = float(text)
    elif _NOT_FINITE.fullmatch(text):
        value = float(text.replace(".", ""))
    elif _OTHER_INT.fullmatch(text):
        value = int(text, 0) if len(text) <= _MAX_NUMBER else float("inf")
    return value


_SURROGATES = re.compile(r"(?<!\\)((?:\\\\)*)\\u([dD][89abAB][0-9a-fA-F]{2})\\u([dD][c-fC-F][0-9a-fA-F]{2})")


def as_yaml(text: str) -> str:
    """Return JSON as YAML, which has no tabs between values and no surrogate pairs, so that its lines are known."""
    return _SURROGATES.sub(_join, text.replace("\t", " "))


def _join(match: re.Match[str]) -> str:
    high, low = int(match[2], 16), int(match[3], 16)
    return f"{match[1]}\\U{0x10000 + ((high - 0xD800) << 10) + (low - 0xDC00):08x}"
