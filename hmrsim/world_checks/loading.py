"""Loading a world from one or several files, with all errors at once."""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from itertools import islice
from typing import TYPE_CHECKING, Any, Final, TypeAlias

from hmrsim.caches import FileCache
from hmrsim.diagnostics import MAX_FINDINGS, in_order
from hmrsim.documents.document import LineOf, no_line
from hmrsim.documents.valid_parts import UNRESOLVED, Lost, ValidParts, valid_parts
from hmrsim.errors import Problem, WorldError
from hmrsim.world.files import AS_IT_IS, ReadOptions, find
from hmrsim.world.formats import Document
from hmrsim.world.includes import read_all
from hmrsim.world.merging import Merged, Source, added_item, added_robot
from hmrsim.world.model import Derived, Lane, PlainLanes, Waypoint, World
from hmrsim.world.overlays.overlay import Overlay, lay_all
from hmrsim.world_checks.checks import check, check_errors

if TYPE_CHECKING:
    from pathlib import Path

    from hmrsim.diagnostics import Finding


_STAND_INS: Final[Mapping[tuple[str, ...], Any]] = {
    ("docks", "*", "at"): UNRESOLVED,
    ("items", "*", "at"): UNRESOLVED,
    ("robots", "*", "at"): UNRESOLVED,
    ("demand", "*", "at"): [UNRESOLVED],
    ("demand", "*", "to"): [UNRESOLVED],
    ("demand", "*", "arrives"): 1.0,
}
"""Values for invalid ones, by their paths, so that the rest of the entry is checked."""

_PIECE = 10_000
"""Lanes and waypoints that are hashed at a time."""


@dataclass(frozen=True)
class LoadedWorld:
    """A valid world, with its warnings and files.

    Attributes:
        files: The files from which it was read: *path*, and those that it includes.
        warnings: Settings that can be run but are unlikely to be intended.
    """

    world: World
    path: Path
    warnings: tuple[Problem, ...]
    files: tuple[Path, ...] = ()

    @property
    def hash(self) -> str:
        """SHA-256 of the world in canonical JSON, as 64 hex digits; equal worlds have equal hashes."""
        return world_hash(self.world)


def load_world(
    source: str | Path,
    *,
    add_robots: Sequence[str] = (),
    add_items: Sequence[str] = (),
    options: ReadOptions = AS_IT_IS,
    overlays: Sequence[Overlay] = (),
    further: Sequence[Callable[[World], Iterable[Finding]]] = (),
) -> LoadedWorld:
    """Read a world with the files that it includes, and check it.

    Args:
        source: A file of any format, or the bare name of a shipped world.
        add_robots: Further robots, each ``NAME@X,Y[:TYPE]``.
        add_items: Further items, each ``NAME@X,Y[:KG]``.
        options: How to read drawings.
        overlays: Changes that are applied to all of it, in this order.
        further: Slow checks, which run only for a world without errors.

    Raises:
        WorldError: The world is invalid; it has all errors in file order, then all warnings.
    """
    path = find(source)
    if options == AS_IT_IS and not (add_robots or add_items):
        return _of_file(path).load(overlays, further)
    merged = read_all(path, str(path), options)
    for texts, parse in ((add_robots, added_robot), (add_items, added_item)):
        for text in texts:
            try:
                merged.add(parse(text))
            except WorldError as error:
                merged.problems += error.problems
    return _checked(merged, path, overlays, further)


_Parts: TypeAlias = dict[str, tuple[str, Any]]
"""The fields of a world that was loaded before, each with its text in the file, which may be empty."""


def _checked(
    merged: Merged,
    path: Path,
    overlays: Sequence[Overlay],
    further: Sequence[Callable[[World], Iterable[Finding]]] = (),
    parts: _Parts | None = None,
) -> LoadedWorld:
    """Return the world of files with overlays applied.

    Args:
        merged: The content of the files.
        path: The first of them.
        overlays: The overlays, in order.
        further: Further checks, as in `load_world`.
        parts: The fields of an earlier world of the same files; updated.

    Raises:
        WorldError: The world is invalid; it has all errors.
    """
    lay_all((*map(Overlay, reversed(merged.overlays)), *overlays), merged)
    valid = validate(merged.data)
    if parts is not None and valid.value is not None and not valid.findings:
        valid = replace(valid, value=_sharing(valid.value, merged, parts))
    lost = valid.lost
    if not merged.complete or lost.touches("include"):
        lost = Lost(dict.fromkeys(World.model_fields))
    findings = list(valid.findings)
    if valid.value is not None:
        findings += [valid.original_of(finding) for finding in check(valid.value, lost)]
    severities = {finding.severity for finding in findings} | {problem.severity for problem in merged.problems}
    if valid.value is not None and not lost and "error" not in severities:
        findings += [finding for find in further for finding in islice(find(valid.value), MAX_FINDINGS)]
    problems = in_order([*merged.problems, *(merged.problem(finding) for finding in findings)], str(path))
    if valid.value is None or any(problem.severity == "error" for problem in problems):
        raise WorldError(problems)
    return LoadedWorld(valid.value, path, tuple(problems), tuple(sorted(merged.paths)))


def _sharing(world: World, merged: Merged, parts: _Parts) -> World:
    """Return a world that shares the fields that are the same with an earlier one, and what is derived from them."""
    same = {}
    for name in World.model_fields:
        try:
            text = _exact(merged.data[name]) if name in merged.data else ""
        except TypeError:  # lanes of a grid
            continue
        before = parts.get(name)
        if before is not None and before[0] == text:
            same[name] = before[1]
        else:
            parts[name] = text, getattr(world, name)
    return world.model_copy(update=same)


@dataclass(frozen=True)
class BaseWorld:
    """The content of a world file, for many worlds that differ by overlays; see `base_world`.

    Attributes:
        path: The file.
        merged: The file with all files that it includes, which must not be modified.
    """

    path: Path
    merged: Merged
    _parts: _Parts = field(default_factory=dict, compare=False, repr=False)

    def load(
        self, overlays: Sequence[Overlay] = (), further: Sequence[Callable[[World], Iterable[Finding]]] = ()
    ) -> LoadedWorld:
        """Return the checked world with overlays applied; *further* are checks as in `load_world`.

        Raises:
            WorldError: The world is invalid; it has all errors.
        """
        if overlays or further:
            return _checked(self.merged.copied(), self.path, overlays, further, self._parts)
        return self._as_it_is

    @cached_property
    def _as_it_is(self) -> LoadedWorld:
        return _checked(self.merged.copied(), self.path, (), parts=self._parts)


def base_world(source: str | Path) -> BaseWorld:
    """Return the content of a world file of any format, or of a shipped world by its bare name.

    Raises:
        WorldError: The file itself can't be read.
    """
    return _of_file(find(source))


def _of_file(path: Path) -> BaseWorld:
    # Errors name a file as the user does.
    return _READ.get(
        (str(path), path.absolute()),
        lambda: BaseWorld(path, read_all(path, str(path))),
        lambda base: (*base.merged.paths, *base.merged.absent),
    )


_READ: Final[FileCache[BaseWorld]] = FileCache(16)


def world_of(
    data: dict[str, Any],
    source: str,
    overlays: Sequence[Overlay] = (),
    first: Callable[[World], Iterable[Finding]] = lambda _world: (),
    line: LineOf = no_line,
) -> World:
    """Return the checked world of plain values, which may not include files.

    Args:
        data: The world, as in a native file.
        source: The name of its origin, for errors.
        overlays: Changes that are applied to it, in this order.
        first: A check that runs before all others; if it finds errors, the others don't run.
        line: Returns the line of a field of *data*, for errors.

    Raises:
        WorldError: The world is invalid; it has all errors.
    """
    merged = Merged(Source(source, Document(data, line)))
    lay_all((*map(Overlay, reversed(merged.overlays)), *overlays), merged)
    valid = validate(merged.data)
    findings = list(valid.findings)
    if valid.value is not None:
        invalid = [*first(valid.value)] or check_errors(valid.value, valid.lost)
        findings += [valid.original_of(finding) for finding in invalid]
    problems = [*merged.problems, *(merged.problem(finding) for finding in findings)]
    errors = [problem for problem in problems if problem.severity == "error"]
    if valid.value is None or errors:
        raise WorldError(errors)
    return valid.value


def validate(data: Mapping[str, Any]) -> ValidParts[World]:
    """Return the world of plain values without the invalid parts, and the errors."""
    return valid_parts(data, World, stand_ins=_STAND_INS)


def world_hash(world: World) -> str:
    """Return the SHA-256 of a world in canonical JSON, as 64 hex digits; it is computed once for each world.

    Fields with their default are left out, so that new keys of worlds don't change the hashes of existing ones.
    """
    return _HASHES(world)


def _digest(world: World) -> str:
    digest = hashlib.sha256()
    # A search runs one world with thousands of different faults.
    texts = _UNFAULTY(world) | _texts(world, "faults")
    if not _is_small(world):
        texts |= {key: pieces(world) for key, pieces in _LARGE.items()}
    for i, key in enumerate(sorted(texts)):
        digest.update(f"{'{,'[i > 0]}{_canonical(key)}:".encode("ascii"))
        for text in texts[key]:
            digest.update(text.encode("ascii"))
    digest.update(b"}")
    return digest.hexdigest()


def _texts(world: World, field: str) -> dict[str, Iterable[str]]:
    """Return the canonical JSON of a field by its key; none if it has its default, or is too large to be kept."""
    if field in _LARGE:
        return {field: [*_LARGE[field](world)]} if _is_small(world) else {}
    data = world.model_dump(mode="json", by_alias=True, exclude_defaults=True, include={field})
    for name, robot in world.robots.items() if field == "robots" else ():
        if robot.base.model_fields_set:  # null overrides the type's settings
            data["robots"][name]["base"] = robot.base.model_dump(mode="json", exclude_unset=True)
    return {key: [_canonical(said)] for key, said in data.items()}


def _is_small(world: World) -> bool:
    return max(len(world.lanes), len(world.waypoints)) <= _PIECE


def _lanes(world: World) -> Iterator[str]:
    """Yield the canonical JSON of lanes in pieces, because that of a grid has 80 MB."""
    lanes = world.lanes
    if not isinstance(lanes, PlainLanes):
        yield _canonical([lane.model_dump(mode="json", by_alias=True, exclude_defaults=True) for lane in lanes])
        return
    lane = Lane(from_="a", to="b").model_dump(mode="json", by_alias=True, exclude_defaults=True)
    before, between, after = re.split('"[ab]"', _canonical(lane))
    name = [_canonical(name) for name in lanes.pairs.names].__getitem__
    pairs = zip(map(name, lanes.pairs.starts), map(name, lanes.pairs.ends), strict=True)
    yield "["
    for i in range(0, len(lanes), _PIECE):
        texts = [f"{before}{a}{between}{b}{after}" for a, b in islice(pairs, _PIECE)]
        yield f"{',' if i else ''}{','.join(texts)}"
    yield "]"


def _waypoints(world: World) -> Iterator[str]:
    """Yield the canonical JSON of waypoints in pieces."""
    names = sorted(world.waypoints)
    yield "{"
    for i in range(0, len(names), _PIECE):
        parts = ((name, world.waypoints[name]) for name in names[i : i + _PIECE])
        plain = {
            name: at.model_dump(mode="json", exclude_defaults=True) if isinstance(at, Waypoint) else at
            for name, at in parts
        }
        yield f"{',' if i else ''}{_canonical(plain)[1:-1]}"
    yield "}"


_LARGE: Final[Mapping[str, Callable[[World], Iterator[str]]]] = {"lanes": _lanes, "waypoints": _waypoints}
"""The parts of a world that may be large, and what yields their canonical JSON in pieces."""

_FIELDS: Final = tuple(name for name in World.model_fields if name != "faults")
_TEXTS: Final = [Derived(partial(_texts, field=name), *(_LARGE if name in _LARGE else (name,))) for name in _FIELDS]
"""Return the canonical JSON of a field: worlds that differ by overlays share most fields."""
_UNFAULTY: Final = Derived(lambda world: {key: text for each in _TEXTS for key, text in each(world).items()}, *_FIELDS)
_HASHES: Final = Derived(lambda world: _digest(world))  # noqa: PLW0108 - tests replace the function

_exact = json.JSONEncoder().encode
"""Returns plain values as text that distinguishes all values that a world distinguishes, and the order of keys."""
_canonical = json.JSONEncoder(sort_keys=True, separators=(",", ":"), ensure_ascii=True, allow_nan=False).encode
