"""The base of all parts of a file of properties: their types, a walk over them, and the names that they stand for."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Final, TypeVar, Union

from pydantic import BaseModel, BeforeValidator, ConfigDict, Discriminator, Field, Tag

from hmrsim.diagnostics import meant, shown

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path

EACH: Final = "*"
"""Stands for each robot on its own."""

BOUND: Final = "$"
"""Begins the name of a field of the event that has triggered a property."""

Identifier = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=60)]
Name = Annotated[str, Field(min_length=1, max_length=100)]
Seconds = Annotated[float, Field(strict=True, gt=0, le=1e9)]
Count = Annotated[int, Field(strict=True, ge=1, le=1_000_000)]


class Part(BaseModel):
    """A part of a file of properties: unknown keys, NaN and infinity are errors.

    A field that is named by a keyword of Python ends with an underscore; in a file, it does not.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True)


def key_of(value: Any, kinds: Mapping[str, type[BaseModel]]) -> str | None:
    """Return the first key of *kinds* that a mapping has, or the key of a model; None if there is none."""
    if isinstance(value, BaseModel):
        return next((key for key, kind in kinds.items() if type(value) is kind), None)
    return next((key for key in kinds if key in value), None) if isinstance(value, Mapping) else None


def one_of(kinds: Mapping[str, type[BaseModel]], noun: str, expected: str, keys: str) -> Any:
    """Return the type of a part that is of one of some kinds, which its keys tell.

    Args:
        kinds: The models by their keys; the first key that a mapping has counts.
        noun: The name of such a part, for errors.
        expected: A description of such a part, for errors.
        keys: A description of the keys, for errors.
    """
    # Tags differ from the keys of a file, so that paths of errors show which is which.
    tags = {kind: f"<{key}>" for key, kind in reversed([*kinds.items()])}

    def tag(value: Any) -> str | None:
        key = key_of(value, kinds)
        return None if key is None else tags[kinds[key]]

    def known(value: Any) -> Any:
        if key_of(value, kinds) is not None:
            return value
        if not isinstance(value, Mapping):
            raise ValueError(f"expected {expected}, got {shown(value)}")  # noqa: TRY004 - of a file, not of a program
        alike = next((f"; did you mean {alike!r}?" for key in value if (alike := meant(str(key), kinds))), "")
        raise ValueError(f"is no {noun}{alike or f'; one {keys}'}")

    members = tuple(Annotated[kind, Tag(tag)] for kind, tag in reversed(tags.items()))
    union: Any = Union[members]  # noqa: UP007 - of a tuple
    return Annotated[Annotated[union, Discriminator(tag)], BeforeValidator(known)]


def walk(part: BaseModel, path: Path = ()) -> Iterator[tuple[Path, BaseModel]]:
    """Yield all parts of a part, itself first, each with its path in the file."""
    yield path, part
    for name, field in type(part).model_fields.items():
        value = getattr(part, name)
        if isinstance(value, BaseModel):
            yield from walk(value, (*path, field.alias or name))
        elif isinstance(value, (tuple, dict)):
            for key, each in value.items() if isinstance(value, dict) else enumerate(value):
                if isinstance(each, BaseModel):
                    yield from walk(each, (*path, field.alias or name, key))


def texts(part: BaseModel) -> Iterator[tuple[Path, str]]:
    """Yield the texts of a part itself, with their paths in it."""
    for name, field in type(part).model_fields.items():
        value, key = getattr(part, name), field.alias or name
        if isinstance(value, str):
            yield (key,), value
        elif isinstance(value, dict):
            yield from (((key, inner), each) for inner, each in value.items() if isinstance(each, str))
        elif isinstance(value, tuple):
            yield from (((key, i), each) for i, each in enumerate(value) if isinstance(each, str))


P = TypeVar("P", bound=BaseModel)

_OF_ROBOTS: Final = ("robot", "battery", "carried_by")
"""Fields that name a robot."""


def speaks_of_each(part: BaseModel) -> bool:
    """Return whether a part is about each robot."""
    return any(vars(each).get(name) == EACH for _, each in walk(part) for name in _OF_ROBOTS)


def for_robot(part: P, robot: str) -> P:
    """Return a part with the name of a robot in place of ``*``."""
    return _filled(part, lambda name, value: robot if name in _OF_ROBOTS and value == EACH else value)


def bound_names(part: BaseModel) -> list[str]:
    """Return the fields of a trigger's event that a part names."""
    found: dict[str, None] = {}
    for _, each in walk(part):
        for _, value in texts(each):
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
