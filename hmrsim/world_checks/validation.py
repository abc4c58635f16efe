"""Validation of a world that continues after an error, so that all errors are found at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

from pydantic import BaseModel, ValidationError

from hmrsim.diagnostics import MAX_FINDINGS, Finding
from hmrsim.documents.validation import explain
from hmrsim.world.model import (
    Base,
    Demand,
    Dock,
    Door,
    FaultEntry,
    Item,
    Lane,
    Lift,
    Place,
    RobotSpec,
    RobotType,
    Solid,
    Waypoint,
    World,
)

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path

_PARTS: Final[Mapping[tuple[str, ...], type[BaseModel]]] = {
    (): World,
    ("lanes", "*"): Lane,
    ("walls", "*"): Solid,
    ("waypoints", "*"): Waypoint,
    ("places", "*"): Place,
    ("docks", "*"): Dock,
    ("doors", "*"): Door,
    ("lifts", "*"): Lift,
    ("items", "*"): Item,
    ("robot_types", "*"): RobotType,
    ("robot_types", "*", "base"): Base,
    ("robots", "*"): RobotSpec,
    ("robots", "*", "base"): Base,
    ("faults", "*"): FaultEntry,
    ("demand", "*"): Demand,
}
"""The models of the parts of a world, by their paths."""

_ROUNDS = 20
"""Maximum number of passes, as removing a field can make another one invalid."""

_Dead = dict[str | int, Any]


@dataclass(frozen=True)
class Lost:
    """The invalid parts of a world, which were removed, so that no check reports them as missing.

    Attributes:
        names: By top-level key, the names that are gone; None when any name may be.
    """

    names: Mapping[str, frozenset[str] | None] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """Return whether any part was removed."""
        return bool(self.names)

    def has(self, name: str, *keys: str) -> bool:
        """Return whether *name* may be that of a part removed under one of these top-level keys."""
        for key in keys:
            if key in self.names:
                gone = self.names[key]
                if gone is None or name in gone:
                    return True
        return False


@dataclass(frozen=True)
class Validated:
    """The valid part of a world.

    Attributes:
        world: The world without the parts with errors; None if no part is valid.
        findings: The errors, with paths in the file.
        kept: By top-level list, the index in the file of each item that is left; absent when all are.
    """

    world: World | None
    findings: tuple[Finding, ...]
    lost: Lost
    kept: Mapping[str, tuple[int, ...]]

    def original_of(self, finding: Finding) -> Finding:
        """Return a finding about the world as one about the file."""
        return replace(finding, path=_original(finding.path, self.kept))


def validate(data: dict[str, Any]) -> Validated:
    """Return the world of *data* without the invalid parts, and the errors."""
    dead: _Dead = {}
    findings: list[Finding] = []
    world = None
    for _ in range(_ROUNDS):
        rest = {key: _without(value, dead.get(key, {})) for key, value in data.items() if _alive(dead, key)}
        kept = _kept(data, dead)
        try:
            world = World.model_validate(rest)
            break
        except ValidationError as error:
            found = [replace(one, path=_original(one.path, kept)) for one in explain(error, rest, _PARTS)]
            count = error.error_count()
        for finding in found:
            if not _is_dead(dead, finding.path):
                findings.append(finding)
            _kill(data, dead, finding.path)
        if count > MAX_FINDINGS:
            text = f"has {count} errors; only these are reported"
            findings = [Finding((), text, count), *findings][:MAX_FINDINGS]
            break
    return Validated(world, tuple(findings), _lost(data, dead, world), _kept(data, dead))


def _original(path: Path, kept: Mapping[str, tuple[int, ...]]) -> Path:
    """Return the path in the file of a path in the remaining data."""
    if len(path) > 1 and path[0] in kept and isinstance(path[1], int):
        return (path[0], kept[str(path[0])][path[1]], *path[2:])
    return path


def _alive(dead: _Dead, key: str | int) -> bool:
    return dead.get(key, {}) is not None


def _without(value: Any, dead: _Dead) -> Any:
    if not dead:
        return value
    if isinstance(value, dict):
        return {key: _without(part, dead.get(key, {})) for key, part in value.items() if _alive(dead, key)}
    return [_without(part, dead.get(i, {})) for i, part in enumerate(value) if _alive(dead, i)]


def _kept(data: dict[str, Any], dead: _Dead) -> dict[str, tuple[int, ...]]:
    return {
        key: tuple(i for i in range(len(data[key])) if _alive(gone, i))
        for key, gone in dead.items()
        if isinstance(key, str) and gone and isinstance(data.get(key), list)
    }


def _is_dead(dead: _Dead, path: Path) -> bool:
    here: _Dead | None = dead
    for step in path:
        here = here.get(step, {}) if here is not None else None
    return here is None


def _kill(data: dict[str, Any], dead: _Dead, path: Path) -> None:
    """Remove the smallest part of the file that holds *path* and is still there."""
    cut = _cut(data, path)
    while cut and _is_dead(dead, cut):
        cut = cut[:-1]
    if not cut:
        dead.update(dict.fromkeys(data))
        return
    here = dead
    for step in cut[:-1]:
        here = here.setdefault(step, {})
    here[cut[-1]] = None


def _cut(data: dict[str, Any], path: Path) -> Path:
    """Return the part to remove: whole lists inside of an entry, and whole entries that lack a field."""
    value: Any = data
    for i, step in enumerate(path):
        if isinstance(value, list) and (i != 1 or not isinstance(step, int)):
            return path[:i]
        try:
            value = value[step]
        except (LookupError, TypeError):
            return path[:i]
    return path


def _lost(data: dict[str, Any], dead: _Dead, world: World | None) -> Lost:
    names: dict[str, frozenset[str] | None] = {}
    for key, gone in dead.items():
        value = data.get(str(key))
        if gone is None or world is None or not isinstance(value, dict):
            names[str(key)] = None
        else:
            left = getattr(world, str(key), {})
            names[str(key)] = frozenset(value) - frozenset(left if isinstance(left, dict) else ())
    return Lost(names)
