"""Merging several files into one world, with the origin of each part."""

from __future__ import annotations

import re
from copy import copy
from dataclasses import dataclass, field
from operator import itemgetter
from typing import TYPE_CHECKING, Any

from hmrsim.diagnostics import Finding, dotted, problem_of, shown
from hmrsim.errors import Problem, WorldError
from hmrsim.world.formats import Document
from hmrsim.world.network import Pairs

if TYPE_CHECKING:
    import pathlib

    from hmrsim.diagnostics import Path

_MAPS = ("waypoints", "places", "docks", "doors", "lifts", "items", "robot_types", "robots", "remap")
_NOT_OF_WORLDS = ("include", "overlay")
"""Keys of a file that do not belong to the world."""

_LISTS = ("lanes", "walls", "faults", "demand")


@dataclass(frozen=True)
class Source:
    """A file, or the option that adds to it.

    Attributes:
        file: Its name as the user knows it.
    """

    file: str
    document: Document

    def problem(self, finding: Finding) -> Problem:
        """Return a finding about this file as a problem."""
        return problem_of(finding, self.file, self.document.line)


def own(value: Any) -> Any:
    """Return a deep copy of the mappings and lists of a value."""
    if isinstance(value, dict):
        return {key: own(part) for key, part in value.items()}
    return [own(part) for part in value] if isinstance(value, list) else value


@dataclass
class Merged:
    """Several files merged into one.

    Attributes:
        root: The file that the others are added to.
        data: The top-level keys of a world.
        problems: The problems of the files themselves.
        paths: The files themselves.
        absent: Missing files that would take precedence over shipped worlds.
        overlays: The overlays of the files, the last one first.
        complete: Whether all files could be read, so that a missing name is an error.
    """

    root: Source
    data: dict[str, Any] = field(default_factory=dict)
    problems: list[Problem] = field(default_factory=list)
    paths: set[pathlib.Path] = field(default_factory=set)
    absent: set[pathlib.Path] = field(default_factory=set)
    overlays: list[Source] = field(default_factory=list)
    complete: bool = True
    _owners: dict[Path, tuple[Source, Path]] = field(default_factory=dict)
    _laid: dict[Path, tuple[int, Source, Path]] = field(default_factory=dict)
    _claims: int = 0

    def __post_init__(self) -> None:
        """Add the content of the root."""
        self.add(self.root)

    def problem(self, finding: Finding) -> Problem:
        """Return a finding about the data as a problem of the file that it is from."""
        lengths = range(1, len(finding.path) + 1) if self._laid else ()
        laid = [self._laid[finding.path[:length]] for length in lengths if finding.path[:length] in self._laid]
        if not laid and self._laid and not self._is_in_files(finding.path):
            # A mapping that a change has created for its value.
            laid = [claim for at, claim in self._laid.items() if at[: len(finding.path)] == finding.path]
        if laid:
            _, source, place = max(laid, key=itemgetter(0))
            line = source.document.line(place)
            return Problem(source.file, dotted(finding.path), finding.message, line, finding.value, finding.severity)
        source, start = self._owner(finding.path)
        path = (*start, *finding.path[len(start) :])
        return source.problem(Finding(path, finding.message, finding.value, finding.severity, finding.line))

    def copied(self) -> Merged:
        """Return a copy to which overlays can be added."""
        twin = copy(self)
        twin.data, twin.problems, twin.paths = {**self.data}, [*self.problems], {*self.paths}
        twin.overlays, twin._laid = [*self.overlays], {**self._laid}  # noqa: SLF001 - the same class
        return twin

    def unshare(self) -> None:
        """Copy all mappings and lists of the data, so that they can be changed in place."""
        self.data = {key: own(value) for key, value in self.data.items()}

    def claim(self, path: Path, source: Source, place: Path) -> None:
        """Record *source* as the origin of the data at a path; *place* is its path in the source."""
        # The latest claim above or below a path counts.
        self._claims += 1
        self._laid[path] = (self._claims, source, place)

    def _is_in_files(self, path: Path) -> bool:
        """Return whether the file that defines a part of the world also defines the path."""
        part: Any = self._owner(path)[0].document.data
        for step in path:
            if isinstance(part, (list, Pairs)) and isinstance(step, int):
                known = 0 <= step < len(part)
            else:
                known = isinstance(part, dict) and step in part
            if not known:
                return False
            part = part[step]
        return True

    def _owner(self, path: Path) -> tuple[Source, Path]:
        return self._owners.get(path[:2]) or self._owners.get(path[:1]) or (self.root, ())

    def add(self, source: Source) -> None:
        """Merge mappings and concatenate lists; an existing value of another kind is kept."""
        self.problems += [source.problem(finding) for finding in source.document.findings]
        for key, said in source.document.data.items():
            # Lanes of a grid become a list when other lanes are added.
            value = [*said] if isinstance(said, Pairs) and key in self.data else said
            if key == "overlay":
                self._keep_overlay(value, source)
            if key in _NOT_OF_WORLDS:
                continue
            if key in _MAPS and isinstance(value, dict) and isinstance(self.data.get(key, {}), dict):
                self._unite(key, value, source)
            elif key in _LISTS and isinstance(value, list) and isinstance(self.data.get(key, []), (list, Pairs)):
                self._join(key, value, source)
            elif key not in self.data:
                self.data[key] = value
                self._owners[key,] = (source, (key,))
            elif key == "units" and value != self.data[key]:
                other = self._owner((key,))[0].file
                message = f"{shown(value)} can't be joined with {shown(self.data[key])} of {other}"
                self.problems.append(source.problem(Finding((key,), message, value)))

    def _keep_overlay(self, value: Any, source: Source) -> None:
        if not isinstance(value, dict):
            message = f"expected a mapping of paths to values, got {shown(value)}"
            self.problems.append(source.problem(Finding(("overlay",), message, value)))
            return
        line = source.document.line
        self.overlays.append(Source(source.file, Document(value, lambda path: line(("overlay", *path)))))

    def _unite(self, key: str, value: dict[str, Any], source: Source) -> None:
        if key not in self.data:
            self.data[key] = dict(value)
            self._owners[key,] = (source, (key,))
            return
        mine = self.data[key]
        for name, part in value.items():
            if name in mine:
                other = self._owner((key, name))[0].file
                message = f"{name!r} is in {other} already; give one of the two another name"
                self.problems.append(source.problem(Finding((key, name), message, name)))
            else:
                mine[name] = part
                self._owners[key, name] = (source, (key, name))

    def _join(self, key: str, value: list[Any], source: Source) -> None:
        if key not in self.data:
            self.data[key] = [*value]
            self._owners[key,] = (source, (key,))
            return
        mine = self.data[key] = [*self.data[key]]
        for i, part in enumerate(value):
            self._owners[key, len(mine)] = (source, (key, i))
            mine.append(part)


_NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d{1,3})?"
_ADDITION = re.compile(rf"(?P<name>[^@]+)@(?P<x>{_NUMBER}),(?P<y>{_NUMBER})(?::(?P<rest>.+))?", re.ASCII)


def added_robot(text: str) -> Source:
    """Return the source with the robot of a ``--robot`` option.

    Raises:
        WorldError: *text* is not as expected.
    """
    name, fields, kind = _parse(text, "--robot", "NAME@X,Y or NAME@X,Y:TYPE")
    if kind is not None:
        fields["type"] = kind
    return Source(f"--robot {text}", Document({"robots": {name: fields}}))


def added_item(text: str) -> Source:
    """Return the source with the item of an ``--item`` option.

    Raises:
        WorldError: *text* is not as expected.
    """
    expected = "NAME@X,Y or NAME@X,Y:KG"
    name, fields, weight = _parse(text, "--item", expected)
    if weight is not None:
        if not re.fullmatch(_NUMBER, weight, re.ASCII):
            raise _error("--item", text, expected)
        fields["weight"] = float(weight)
    return Source(f"--item {text}", Document({"items": {name: fields}}))


def _parse(text: str, option: str, expected: str) -> tuple[str, dict[str, Any], str | None]:
    match = _ADDITION.fullmatch(text)
    if match is None:
        raise _error(option, text, expected)
    return match["name"], {"at": [float(match["x"]), float(match["y"])]}, match["rest"]


def _error(option: str, text: str, expected: str) -> WorldError:
    return WorldError([Problem(f"{option} {text}", "", f"expected {expected}")])
