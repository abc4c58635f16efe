"""Validation that continues after an error, so that all errors of a document are found at once."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Generic, Literal, TypeAlias, TypeVar

from pydantic import BaseModel, ValidationError

from hmrsim.diagnostics import MAX_FINDINGS, Finding, meant
from hmrsim.documents.validation import explain

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path

M = TypeVar("M", bound=BaseModel)

UNRESOLVED: Final = "\0"
"""The stand-in for an invalid name; nothing has this name, and no check reports that nothing has it."""

_ROUNDS = 20
"""Maximum number of passes, as removing a field can make another one invalid."""

_Gone: TypeAlias = "dict[str | int, _Gone | Literal[False] | None]"
"""The invalid parts by key or index: None if one was removed, False if a stand-in has replaced it."""


@dataclass(frozen=True)
class Lost:
    """The invalid parts of a document, so that no check reports an error that only follows from them.

    Attributes:
        names: By top-level key, the names of the entries that lack a part or are gone; None if any name may be gone.
    """

    names: Mapping[str, frozenset[str] | None] = field(default_factory=dict)

    def __bool__(self) -> bool:
        """Return whether any part is invalid."""
        return bool(self.names)

    def has(self, name: str, *keys: str) -> bool:
        """Return whether *name* may be that of an invalid entry under one of these top-level keys."""
        return (name == UNRESOLVED and bool(self)) or any(
            names is None or name in names for names in (self.names[key] for key in keys if key in self.names)
        )

    def touches(self, *keys: str) -> bool:
        """Return whether any part under one of these top-level keys is invalid."""
        return not self.names.keys().isdisjoint(keys)


@dataclass(frozen=True)
class ValidParts(Generic[M]):
    """The valid parts of a document.

    Attributes:
        value: The document without the invalid parts; None if nothing can be read without them.
        findings: The errors, with paths in the document.
        lost: The invalid parts.
        kept: By top-level list, the index in the document of each item that is left; absent when all are.
    """

    value: M | None
    findings: tuple[Finding, ...]
    lost: Lost
    kept: Mapping[str, tuple[int, ...]]

    def original_of(self, finding: Finding) -> Finding:
        """Return a finding about the valid parts as one about the document."""
        return replace(finding, path=_original(finding.path, self.kept))


def valid_parts(
    data: Mapping[str, Any],
    model: type[M],
    stand_ins: Mapping[tuple[str, ...], Any] = MappingProxyType({}),
) -> ValidParts[M]:
    """Return *data* as a model without the invalid parts, and the errors.

    Args:
        data: The content of a document.
        model: Its model.
        stand_ins: Values by path, in which ``*`` is any key or index. One takes the place of a required value that is
            missing or invalid, so that the rest of its entry is kept.
    """
    gone: _Gone = {}
    findings: list[Finding] = []
    value = None
    rest = dict(data)
    for _ in range(_ROUNDS):
        kept = _kept(rest, gone)
        left = _without(rest, gone)
        try:
            value = model.model_validate(left)
            break
        except ValidationError as error:
            found = [replace(one, path=_original(one.path, kept)) for one in explain(error, left, model)]
            count = error.error_count()
        # The others follow from parts that are gone.
        fresh = {finding.path: finding for finding in found if _gone_in(gone, finding.path) == {}}
        findings += fresh.values()
        for finding in found:
            # An entry that this round has removed may have further errors.
            if finding.path not in fresh or _gone_in(gone, finding.path) is not None:
                rest = _remove(rest, gone, finding.path, stand_ins)
        if not left:
            break
        if count > MAX_FINDINGS:
            text = f"has {count} errors; only these are reported"
            findings = [Finding((), text, count), *findings][:MAX_FINDINGS]
            break
    return ValidParts(value, tuple(findings), _lost(data, gone, model), _kept(rest, gone))


def _original(path: Path, kept: Mapping[str, tuple[int, ...]]) -> Path:
    """Return the path in the document of a path in the remaining data."""
    if len(path) > 1 and path[0] in kept and isinstance(path[1], int):
        return (path[0], kept[str(path[0])][path[1]], *path[2:])
    return path


def _without(value: Any, gone: Any) -> Any:
    if not gone:
        return value
    if isinstance(value, dict):
        return {key: _without(part, gone.get(key)) for key, part in value.items() if gone.get(key, {}) is not None}
    return [_without(part, gone.get(i)) for i, part in enumerate(value) if gone.get(i, {}) is not None]


def _kept(data: Mapping[str, Any], gone: _Gone) -> dict[str, tuple[int, ...]]:
    return {
        key: tuple(i for i in range(len(data[key])) if below.get(i, {}) is not None)
        for key, below in gone.items()
        if isinstance(key, str) and isinstance(below, dict) and isinstance(data.get(key), list)
    }


def _gone_in(gone: _Gone, path: Path) -> _Gone | None:
    """Return what is gone in the part at a path; None if the part itself is gone."""
    here: Any = gone
    for step in path:
        here = here.get(step, {})
        if not isinstance(here, dict):
            return None
    return here  # type: ignore[no-any-return]  # a mapping


def _remove(data: dict[str, Any], gone: _Gone, path: Path, stand_ins: Mapping[tuple[str, ...], Any]) -> dict[str, Any]:
    """Remove the smallest part that holds *path* and is still there; return the data, perhaps with a stand-in."""
    cut = _cut(data, path)
    for place in (path, cut):
        pattern = next((pattern for pattern in stand_ins if _matches(pattern, place)), None)
        if pattern is not None and _gone_in(gone, place) is not None and isinstance(_at(data, place[:-1]), dict):
            _mark(gone, place, False)
            changed: dict[str, Any] = _replaced(data, place, stand_ins[pattern])
            return changed
    while cut and _gone_in(gone, cut) is None:
        cut = cut[:-1]
    if cut:
        _mark(gone, cut, None)
    else:
        gone.update(dict.fromkeys((*data, *path[:1])))
    return data


def _matches(pattern: tuple[str, ...], path: Path) -> bool:
    return len(pattern) == len(path) and all(step in {"*", at} for step, at in zip(pattern, path, strict=True))


def _mark(gone: _Gone, path: Path, how: Literal[False] | None) -> None:
    here: Any = gone
    for step in path[:-1]:
        here = here.setdefault(step, {})
    here[path[-1]] = how


def _at(data: Any, path: Path) -> Any:
    """Return the value at a path, or None."""
    for step in path:
        try:
            data = data[step]
        except (LookupError, TypeError):
            return None
    return data


def _replaced(data: Any, path: Path, value: Any) -> Any:
    """Return a copy of the data with another value at a path."""
    if not path:
        return value
    first, *below = path
    copy: Any = {**data} if isinstance(data, dict) else [*data]
    copy[first] = _replaced(copy[first], tuple(below), value) if below else value
    return copy


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


def _lost(data: Mapping[str, Any], gone: _Gone, model: type[BaseModel]) -> Lost:
    names: dict[str, frozenset[str] | None] = {}
    known = [field.alias or name for name, field in model.model_fields.items()]
    for key, below in gone.items():
        named = isinstance(below, dict) and isinstance(data.get(str(key)), dict)
        names[str(key)] = frozenset(map(str, below or ())) if named else None
        if key not in known and (similar := meant(str(key), known)):
            # A misspelled key has the entries of another one.
            names[similar] = None
    return Lost(names)
