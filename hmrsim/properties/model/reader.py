"""Reading a file of properties, with all that is wrong in it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, Final

from pydantic import BaseModel, ValidationError

from hmrsim.diagnostics import Finding, instead, shown
from hmrsim.diagnostics import Path as Place
from hmrsim.errors import Problem, PropertyError, WorldError
from hmrsim.events import EventPattern, registry
from hmrsim.properties.model.conditions import CONDITIONS
from hmrsim.properties.model.file import BuiltIn, Properties
from hmrsim.properties.model.formulas import FORMULAS
from hmrsim.properties.model.part import BOUND, EACH, key_of, walk
from hmrsim.properties.model.property import KINDS, DelayedReaction, InstantaneousReaction, Whenever
from hmrsim.world.files import read_text
from hmrsim.world.yaml_text import Unreadable, line_of, read
from hmrsim.world_checks.explain import explain

BINDING: Final = (Whenever, InstantaneousReaction, DelayedReaction)
"""Properties whose ``then`` may have fields of the trigger's event."""

_FORMULA: Final = "formula"

OF_GOALS: Final = ("robot", "action", "goal_id")
"""The fields of a trigger that is about a goal."""


def read_properties(path: str | Path) -> Properties:
    """Return the properties of a file, YAML or JSON.

    Raises:
        PropertyError: Something is wrong; it has all errors of the file.
    """
    file = str(path)
    try:
        data, lines, twice = read(read_text(Path(path), file))
    except WorldError as error:
        raise PropertyError(error.problems) from None
    except Unreadable as error:
        raise PropertyError([Problem(file, "", str(error), error.line)]) from None
    return _read(data, file, partial(line_of, lines), twice)


def properties_of(data: Mapping[str, Any], source: str = "properties") -> Properties:
    """Return the properties that plain values stand for.

    Args:
        data: What a file would say.
        source: Where they come from, for errors.

    Raises:
        PropertyError: Something is wrong; it has all errors.
    """
    return _read(dict(data), source, lambda _path: None, ())


def _read(data: Any, file: str, line: Callable[[Place], int | None], found: Sequence[Finding]) -> Properties:
    findings = [*found]
    if not isinstance(data, dict):
        message = f"expected a mapping with properties, built_in or both, got {shown(data)}"
        raise PropertyError([Problem(file, "", message)])
    try:
        model = Properties.model_validate(data).located(file, line)
    except ValidationError as error:
        findings += [*explain(error, data, parts=_parts(data)), *flaws(_valid(data, error))]
        raise PropertyError(Properties().located(file, line).problems(findings)) from None
    findings += flaws(model)
    if findings:
        raise PropertyError(model.problems(findings))
    return model


def _valid(data: Mapping[str, Any], error: ValidationError) -> Properties:
    """Return the properties that could be read, of a file with errors."""
    wrong = {each["loc"][:2] for each in error.errors(include_url=False, include_input=False)}
    known = data.get("properties")
    if not isinstance(known, dict) or any(len(loc) < 2 for loc in wrong):  # noqa: PLR2004 - not of one property
        return Properties()
    return Properties.model_validate(
        {"properties": {name: each for name, each in known.items() if ("properties", name) not in wrong}}
    )


def _parts(data: Mapping[str, Any]) -> dict[tuple[str, ...], type[BaseModel]]:
    """Return the models of all parts of a file by their paths, as conditions are nested in each other."""
    found: dict[Any, type[BaseModel]] = {(): Properties, ("built_in",): BuiltIn}
    properties = data.get("properties")
    for name, value in properties.items() if isinstance(properties, dict) else ():
        kind = key_of(value, KINDS)
        if kind is not None:
            path = ("properties", name)
            found[path] = KINDS[kind]
            known = FORMULAS if kind == _FORMULA else CONDITIONS
            for key, inner in value.items():
                found |= _nested((*path, key), inner, known)
    return found


def _nested(path: Place, value: Any, known: Mapping[str, type[BaseModel]]) -> Iterator[tuple[Place, type[BaseModel]]]:
    key = next((key for key in known if key in value), None) if isinstance(value, dict) else None
    if key is not None:
        yield path, known[key]
        for name, inner in value.items():
            yield from _nested((*path, name), inner, known)
    elif isinstance(value, list):
        for i, inner in enumerate(value):
            yield from _nested((*path, i), inner, known)


def flaws(properties: Properties) -> Iterator[Finding]:
    """Yield what is wrong with properties whatever the world is."""
    for name, each in properties.properties.items():
        path = ("properties", name)
        if name in BuiltIn.model_fields:
            yield Finding(path, f"{name!r} is a property that is built in; give another name", name)
        for inner, part in walk(each, path):
            if isinstance(part, EventPattern):
                yield from (Finding((*inner, *flaw.path), flaw.message, flaw.value) for flaw in part.flaws())
                yield from (
                    Finding((*inner, "where", key), f"each robot is said beside where: robot: {EACH!r}", value)
                    for key, value in part.where.items()
                    if value == EACH
                )
        yield from _unbound(path, each)
        yield from _twice(path, each)


def _unbound(path: Place, part: BaseModel) -> Iterator[Finding]:
    """Yield an error for each ``$field`` that no trigger binds."""
    bound: list[str] = []
    then: BaseModel | None = None
    trigger = trigger_of(part)
    if isinstance(trigger, EventPattern) and isinstance(part, BINDING):
        bound, then = fields_of(trigger), part.then
    inside = {id(each) for _, each in walk(then)} if then is not None else set()
    for inner, each in walk(part, path):
        for key, value in _texts(each):
            if not value.startswith(BOUND):
                continue
            if id(each) not in inside:
                message = f"{value!r} stands for a field of a trigger's event; it can be used in `then` of one"
                yield Finding((*inner, *key), message, value)
            elif value[1:] not in bound:
                message = f"the trigger has no field {value[1:]!r}{instead(value[1:], bound)}"
                yield Finding((*inner, *key), message, value)


_ORDERED: Final = (
    "ordered_visit",
    "strict_ordered_visit",
    "fair_visit",
    "ordered_patrolling",
    "strict_ordered_patrolling",
    "fair_patrolling",
)
"""Patterns that no run can keep if a place is in them twice."""


def _twice(path: Place, part: BaseModel) -> Iterator[Finding]:
    for field in _ORDERED:
        places = getattr(part, field, ())
        for i, place in enumerate(places):
            if place in places[:i]:
                message = f"{place!r} is there already; a place can have one position in an order"
                yield Finding((*path, field, i), message, place)


def trigger_of(part: BaseModel) -> BaseModel | None:
    """Return the trigger of a property whose ``then`` may have fields of its event; None if it is none."""
    match part:
        case Whenever():
            return part.whenever
        case InstantaneousReaction():
            return part.instantaneous_reaction
        case DelayedReaction():
            return part.delayed_reaction
    return None


def fields_of(trigger: BaseModel) -> list[str]:
    """Return the fields that a trigger's event binds."""
    if not isinstance(trigger, EventPattern):
        return []
    if trigger.goal is not None:
        return [*OF_GOALS]
    kind = registry().get(trigger.event or "")
    fields = [] if kind is None else [name.rstrip("_") for name in kind._fields if name != kind.rest]
    return [*fields, *(["robot"] if kind is not None and kind.rest and "robot" not in fields else [])]


def _texts(part: BaseModel) -> Iterator[tuple[Place, str]]:
    """Yield the texts of a part itself, with their paths in it."""
    for name, field in type(part).model_fields.items():
        value, key = getattr(part, name), field.alias or name
        if isinstance(value, str):
            yield (key,), value
        elif isinstance(value, dict):
            yield from (((key, inner), each) for inner, each in value.items() if isinstance(each, str))
        elif isinstance(value, tuple):
            yield from (((key, i), each) for i, each in enumerate(value) if isinstance(each, str))
