"""Formulas: conditions with windows of time, nested as deep as wanted (Signal Temporal Logic)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Annotated, Any, Final

from pydantic import AfterValidator, BaseModel, BeforeValidator, Discriminator, Field, Tag, WithJsonSchema

from hmrsim.diagnostics import meant, shown
from hmrsim.properties.model.conditions import CONDITIONS, Condition
from hmrsim.properties.model.part import Part


def _window(value: Any) -> Any:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return (0.0, value)
    if isinstance(value, (list, tuple)):
        if len(value) != 2:  # noqa: PLR2004 - from and to
            raise ValueError(f"expected seconds, or [from, to], got {len(value)} numbers")
        return value
    raise ValueError(f"expected seconds, or [from, to], got {shown(value)}")


def _ordered(window: tuple[float, float]) -> tuple[float, float]:
    if window[0] > window[1]:
        raise ValueError(f"the window from {window[0]:g} to {window[1]:g} ends before it begins")
    return window


_Seconds = Annotated[float, Field(strict=True, ge=0, le=1e9)]
_NUMBER: Final[dict[str, Any]] = {"type": "number", "minimum": 0, "maximum": 1e9}
_Window = Annotated[
    tuple[_Seconds, _Seconds],
    BeforeValidator(_window),
    AfterValidator(_ordered),
    WithJsonSchema({"anyOf": [_NUMBER, {"type": "array", "items": _NUMBER, "minItems": 2, "maxItems": 2}]}),
]


class Throughout(Part):
    """A formula holds at each time of a window ahead.

    Attributes:
        within: Seconds from now, or from when to when; None for all time from now on.
    """

    always: FormulaPart
    within: _Window | None = None


class Sometime(Part):
    """A formula holds at some time of a window ahead; *within* likewise."""

    eventually: FormulaPart
    within: _Window | None = None


class UpTo(Part):
    """A formula holds until another one does, at some time of a window ahead; *within* likewise."""

    hold: FormulaPart
    until: FormulaPart
    within: _Window | None = None


class Every(Part):
    """All of some formulas hold."""

    all: tuple[FormulaPart, ...] = Field(min_length=1)


class AnyOne(Part):
    """At least one of some formulas holds."""

    any: tuple[FormulaPart, ...] = Field(min_length=1)


class Opposite(Part):
    """A formula does not hold."""

    not_: FormulaPart = Field(alias="not")


class Conditional(Part):
    """If a formula holds, another one does."""

    if_: FormulaPart = Field(alias="if")
    then: FormulaPart


FORMULAS: Final[Mapping[str, type[BaseModel]]] = MappingProxyType(
    {
        "always": Throughout,
        "eventually": Sometime,
        "hold": UpTo,
        "if": Conditional,
        "all": Every,
        "any": AnyOne,
        "not": Opposite,
        **{key: kind for key, kind in CONDITIONS.items() if key not in {"all", "any", "not"}},
    }
)
"""By the key that tells what a part of a formula is; the first that a mapping has counts."""

_OWN: Final = ("always", "eventually", "hold", "if", "all", "any", "not")


def part_of(value: Any) -> str | None:
    """Return the key that tells what a part of a formula is; None if it is none."""
    if isinstance(value, BaseModel):
        return next((key for key, kind in FORMULAS.items() if type(value) is kind), None)
    return next((key for key in FORMULAS if key in value), None) if isinstance(value, Mapping) else None


def _tag(value: Any) -> str | None:
    key = part_of(value)
    return None if key is None else f"<{key}>" if key in _OWN else "<condition>"


def _known(value: Any) -> Any:
    if part_of(value) is not None:
        return value
    if not isinstance(value, Mapping):
        raise ValueError(f"expected a formula or a condition, got {shown(value)}")  # noqa: TRY004 - of a file
    alike = next((f"; did you mean {alike!r}?" for key in value if (alike := meant(str(key), FORMULAS))), "")
    said = f"; one has a key of {', '.join(_OWN)}, or is a condition"
    raise ValueError(f"is no formula{alike or said}")


FormulaPart = Annotated[
    Annotated[
        Annotated[Throughout, Tag("<always>")]
        | Annotated[Sometime, Tag("<eventually>")]
        | Annotated[UpTo, Tag("<hold>")]
        | Annotated[Conditional, Tag("<if>")]
        | Annotated[Every, Tag("<all>")]
        | Annotated[AnyOne, Tag("<any>")]
        | Annotated[Opposite, Tag("<not>")]
        | Annotated[Condition, Tag("<condition>")],
        Discriminator(_tag),
    ],
    BeforeValidator(_known),
]
"""A part of a formula."""


class Formula(Part):
    """A formula holds at the start of the run."""

    formula: FormulaPart


Throughout.model_rebuild()
Sometime.model_rebuild()
UpTo.model_rebuild()
Every.model_rebuild()
AnyOne.model_rebuild()
Opposite.model_rebuild()
Conditional.model_rebuild()
