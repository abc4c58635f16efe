"""Overlays: files of changes, or single changes of a command line, that are applied to a world."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final

from hmrsim.diagnostics import Finding, instead
from hmrsim.distributions import is_distribution
from hmrsim.documents.document import LineOf, no_line, read_document
from hmrsim.documents.yaml_text import Unreadable, read_yaml
from hmrsim.errors import Problem, WorldError
from hmrsim.world.formats import Document
from hmrsim.world.merging import Source, own
from hmrsim.world.network import Pairs
from hmrsim.world.overlays.changes import (
    APPEND,
    FLAW,
    REMOVE,
    Step,
    TooMuchWorkError,
    Work,
    changes,
    index_of,
    matching,
)
from hmrsim.world.overlays.expressions import OverlayFlaw
from hmrsim.world.overlays.tables import read_tables

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path as FieldPath
    from hmrsim.world.merging import Merged
    from hmrsim.world.overlays.changes import Change
    from hmrsim.world.overlays.expressions import Names

_TABLES: Final = "tables"

_NAMED: Final = ("waypoints", "places", "docks", "doors", "lifts", "items", "robot_types", "robots")
"""The mappings of a world whose keys are names; a path can only lead through existing entries of them."""

_SHORT: Final = {"lanes": ("from", "to"), "waypoints": ("at",)}
"""The keys of entries that can also be written as a list: a lane ``[from, to]``, a waypoint ``[x, y]``."""


@dataclass(frozen=True)
class Overlay:
    """An overlay: changes that are applied to a world.

    Attributes:
        source: The file or option, with its changes.
        names: The values that its expressions can use: tables, and the levels of an experiment's factors.
        files: The files from which it was read.
    """

    source: Source
    names: Names = field(default_factory=lambda: MappingProxyType({}))
    files: tuple[Path, ...] = ()

    def lay_over(self, merged: Merged, work: Work) -> None:
        """Apply the changes in order; the errors become problems of *merged*.

        Raises:
            TooMuchWorkError: The limit of work is exceeded.
        """
        merged.unshare()
        merged.paths.update(self.files)
        merged.problems += [self.source.problem(finding) for finding in self.source.document.findings]
        for change in changes(self.source.document.data, self.names, work):
            if isinstance(change, Finding):
                work.spend(FLAW, change.path)
                merged.problems.append(self.source.problem(change))
                continue
            try:
                for path in _lay(merged.data, change, work):
                    merged.claim(path, self.source, change.path)
            except OverlayFlaw as error:
                work.spend(FLAW, change.path)
                # A file that could not be read may have the missing entry.
                if merged.complete:
                    merged.problems.append(self.source.problem(Finding(change.path, str(error), change.value)))


def lay_all(overlays: Iterable[Overlay], merged: Merged) -> None:
    """Apply overlays to a world in order, with one limit for the work of all.

    Raises:
        WorldError: The limit is exceeded.
    """
    work = Work()
    for overlay in overlays:
        try:
            overlay.lay_over(merged, work)
        except TooMuchWorkError as error:
            # Errors of a world that is changed in part would only follow from this one.
            raise WorldError([overlay.source.problem(Finding(error.path, str(error)))]) from None


def overlay_of(changes: Mapping[str, Any], source: str, line: LineOf = no_line) -> Overlay:
    """Return an overlay with the given changes; *source* names their origin in errors, and *line* returns the lines."""
    return Overlay(Source(source, Document(dict(changes), line)))


def read_overlay(path: str | Path) -> Overlay:
    """Return the overlay of a YAML or JSON file, with the tables under its key ``tables``.

    Raises:
        WorldError: The file or one of its tables can't be read.
    """
    document = read_document(path, WorldError, "a mapping of paths to values such as robots.*.base.speed: 0.8")
    tables, files, flaws = read_tables(document.data.get(_TABLES, {}), Path(path).parent)
    document.raise_for(flaw.within(_TABLES) for flaw in flaws)
    changes = {key: value for key, value in document.data.items() if key != _TABLES}
    source = Source(document.file, Document(changes, document.line))
    return Overlay(source, tables, (Path(path).absolute(), *files))


def setting(text: str) -> Overlay:
    """Return the change of ``--set PATH=VALUE``, or of ``--set ~PATH``, which removes an entry.

    Raises:
        WorldError: *text* is not as expected.
    """
    place = f"--set {text}"
    path, equals, value_text = text.partition("=")
    if text.startswith(REMOVE) and not equals:
        return Overlay(Source(place, Document({text: None})))
    if not equals or not path.strip() or text.startswith(REMOVE):
        raise WorldError([Problem(place, "", "expected PATH=VALUE such as robots.*.base.speed=0.8, or ~PATH")])
    try:
        value, _, findings = read_yaml(value_text) if value_text.strip() else ("", 0, [])
    except Unreadable as error:
        raise WorldError([Problem(place, "", f"the value {error}; put texts with : or # into quotes")]) from None
    if findings:
        raise WorldError([Problem(place, "", finding.message) for finding in findings])
    return Overlay(Source(place, Document({path.strip(): value})))


def overlays_of(files: Iterable[str], settings: Iterable[str]) -> list[Overlay]:
    """Return the overlays of a command line: first the files, then the single changes.

    Raises:
        WorldError: Some are invalid; it has all problems.
    """
    overlays: list[Overlay] = []
    problems: list[Problem] = []
    for texts, parse in ((files, read_overlay), (settings, setting)):
        for text in texts:
            try:
                overlays.append(parse(text))
            except WorldError as error:
                problems += error.problems
    if problems:
        raise WorldError(problems)
    return overlays


def _lay(data: dict[str, Any], change: Change, work: Work) -> list[FieldPath]:
    """Apply a change and return the changed paths, so that errors there can refer to the overlay's line.

    The mappings and lists of *data* that change must not be shared.

    Raises:
        OverlayFlaw: The path of the change leads nowhere.
        TooMuchWorkError: The limit of work is exceeded.
    """
    *parents, last = change.steps
    changed: list[FieldPath] = []
    appends = last == APPEND and not last.quoted and not change.removes
    several = any(step.is_pattern for step in parents)
    size = work.size(change.value)
    compare = partial(work.compare, path=change.path)
    for holder, path in _holders(data, tuple(parents), (), [] if appends else {}, compare):
        if last.searches(holder) and not appends:
            compare(last, holder)
        # Each place gets a copy of the value.
        work.spend(size * (len(holder) if last.is_pattern else 1), change.path)
        if change.removes:
            if not several or last.is_pattern or last in holder:
                _remove(holder, path, last)
        elif isinstance(holder, list) and appends:
            changed += _append(holder, path, change.value)
        else:
            changed += _set(holder, path, last, change.value)
    return changed


def _holders(
    holder: Any,
    steps: tuple[Step, ...],
    path: FieldPath,
    empty: dict[str, Any] | list[Any],
    compare: Callable[[str, Any], None],
) -> Iterator[tuple[dict[str, Any] | list[Any], FieldPath]]:
    """Yield the mappings and lists at the end of the steps; create missing ones: mappings, and last *empty*."""
    if not steps:
        yield holder, path
        return
    step, *rest = steps
    if step.searches(holder):
        compare(step, holder)
    for key in [*_keys(holder, path, step)]:
        part = _opened(holder, key, path, {} if rest else own(empty))
        yield from _holders(part, tuple(rest), (*path, key), empty, compare)


def _opened(holder: Any, key: str | int, path: FieldPath, empty: dict[str, Any] | list[Any]) -> Any:
    """Return an entry of a mapping or list as a mapping that can have entries, and store it."""
    part = holder.get(key) if isinstance(holder, dict) else holder[key]
    if isinstance(part, list) and len(path) == 1 and path[0] in _SHORT:
        keys = _SHORT[str(path[0])]
        part = dict(zip(keys, part if len(keys) > 1 else [part], strict=False))
    elif part is None or is_distribution(part):
        part = empty
    elif isinstance(part, Pairs):
        part = [*part]
    elif not isinstance(part, (dict, list)):
        part = {}
    holder[key] = part
    return part


def _keys(holder: dict[str, Any] | list[Any], path: FieldPath, step: Step) -> Iterator[str | int]:
    """Yield the keys or indices of the entries that a step refers to."""
    if step.is_pattern:
        keys = [*matching(step, holder)]
        if not keys:
            raise OverlayFlaw(f"{_text_of(path)} has nothing that {step} stands for{_entries(holder)}")
        yield from keys
    elif isinstance(holder, list):
        index = index_of(step, holder)
        if index is None:
            raise OverlayFlaw(
                f"{_text_of(path)} is a list of {len(holder)}, in which {step!r} is no index or name; expected 0 "
                f"to {len(holder) - 1}, a name, or {APPEND} to add entries"
            )
        yield index
    elif len(path) == 1 and path[0] in _NAMED and step not in holder:
        raise OverlayFlaw(f"there is no {step!r} among the {path[0]}{instead(step, holder)}")
    else:
        yield str(step)


def _append(entries: list[Any], path: FieldPath, value: Any) -> list[FieldPath]:
    added = own(value) if isinstance(value, list) else [own(value)]
    before = len(entries)
    entries.extend(added)
    return [(*path, before + i) for i in range(len(added))]


def _set(holder: Any, path: FieldPath, last: Step, value: Any) -> Iterator[FieldPath]:
    if isinstance(holder, list) or last.is_pattern:
        for key in _keys(holder, path, last):
            if value != {} or not isinstance(holder[key], (dict, list)):
                holder[key] = own(value)
                yield (*path, key)
        return
    key = str(last)
    if value == {} and isinstance(holder.get(key), (dict, list)):
        return  # further changes follow inside of it
    holder[key] = own(value)
    yield (*path, key)


def _remove(holder: Any, path: FieldPath, last: Step) -> None:
    if isinstance(holder, dict) and not last.is_pattern and last not in holder:
        raise OverlayFlaw(f"{_text_of(path)} has no {str(last)!r} to take away{_entries(holder)}")
    for key in reversed([*_keys(holder, path, last)]):
        del holder[key]


def _text_of(path: FieldPath) -> str:
    return ".".join(str(step) for step in path) or "the world"


def _entries(holder: dict[str, Any] | list[Any]) -> str:
    if isinstance(holder, dict):
        return instead("", holder, verb="it has")
    return f"; it has {len(holder)} entries"
