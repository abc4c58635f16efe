"""What all parts of a file of properties have in common, and a walk over them."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Final

from pydantic import BaseModel, ConfigDict, Field

if TYPE_CHECKING:
    from hmrsim.diagnostics import Path

EACH: Final = "*"
"""Stands for each robot, one after the other."""

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


def walk(part: BaseModel, path: Path = ()) -> Iterator[tuple[Path, BaseModel]]:
    """Yield all parts of a part, itself first, each with its path in the file."""
    yield path, part
    for name, field in type(part).model_fields.items():
        value, inner = getattr(part, name), (*path, field.alias or name)
        if isinstance(value, BaseModel):
            yield from walk(value, inner)
        elif isinstance(value, tuple):
            for i, each in enumerate(value):
                if isinstance(each, BaseModel):
                    yield from walk(each, (*inner, i))
        elif isinstance(value, dict):
            for key, each in value.items():
                if isinstance(each, BaseModel):
                    yield from walk(each, (*inner, key))
