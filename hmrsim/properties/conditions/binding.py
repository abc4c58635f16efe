"""Filling in what stands for something else: ``*`` for a robot, ``$field`` for a field of a trigger's event."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any, TypeVar

from pydantic import BaseModel

from hmrsim.properties.model.part import BOUND, EACH, walk

P = TypeVar("P", bound=BaseModel)

_OF_ROBOTS = ("robot", "battery", "carried_by")
"""Fields that name a robot."""


def speaks_of_each(part: BaseModel) -> bool:
    """Return whether a part is about each robot on its own."""
    return any(getattr(each, name, None) == EACH for _, each in walk(part) for name in _OF_ROBOTS)


def for_robot(part: P, robot: str) -> P:
    """Return a part with the name of a robot in place of ``*``."""
    return _filled(part, lambda name, value: robot if name in _OF_ROBOTS and value == EACH else value)


def bound_names(part: BaseModel) -> list[str]:
    """Return the fields of a trigger's event that a part speaks of."""
    found: dict[str, None] = {}
    for _, each in walk(part):
        for value in _texts(each):
            if value.startswith(BOUND):
                found[value[1:]] = None
    return [*found]


def bound(part: P, fields: Mapping[str, Any]) -> P:
    """Return a part with the values of fields in place of their names."""
    return _filled(
        part,
        lambda _name, value: (
            fields.get(value[1:], value) if isinstance(value, str) and value.startswith(BOUND) else value
        ),
    )


def _texts(part: BaseModel) -> Iterator[str]:
    for name in type(part).model_fields:
        value = getattr(part, name)
        values = value.values() if isinstance(value, dict) else value if isinstance(value, tuple) else (value,)
        yield from (each for each in values if isinstance(each, str))


def _filled(part: P, fill: Callable[[str, Any], Any]) -> P:
    values = {name: _value(name, getattr(part, name), fill) for name in type(part).model_fields}
    return part.model_copy(update=values)


def _value(name: str, value: Any, fill: Callable[[str, Any], Any]) -> Any:
    if isinstance(value, BaseModel):
        return _filled(value, fill)
    if isinstance(value, tuple):
        return tuple(_value(name, each, fill) for each in value)
    if isinstance(value, dict):
        return {key: _value(name, each, fill) for key, each in value.items()}
    return fill(name, value)
