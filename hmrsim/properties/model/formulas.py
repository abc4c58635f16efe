"""Formulas: conditions with windows of time, nested as deep as wanted (Signal Temporal Logic)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated, Any, Final

from pydantic import AfterValidator, BaseModel, BeforeValidator, Field, WithJsonSchema

from hmrsim.diagnostics import shown
from hmrsim.properties.model.conditions import CONDITIONS, Condition
from hmrsim.properties.model.part import Part, one_of


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


def _words(window: tuple[float, float] | None) -> str:
    if window is None:
        return ""
    return f" within {window[1]:g} s" if not window[0] else f" from {window[0]:g} to {window[1]:g} s on"


class Throughout(Part):
    """A formula holds at each time of a window ahead.

    Attributes:
        within: Seconds from now, or from when to when; None for all time from now on.
    """

    always: FormulaPart
    within: _Window | None = None

    def describe(self) -> str:
        """Return the formula in words."""
        return f"always{_words(self.within)} ({self.always.describe()})"


class Sometime(Part):
    """A formula holds at some time of a window ahead; *within* as in `always`."""

    eventually: FormulaPart
    within: _Window | None = None

    def describe(self) -> str:
        """Return the formula in words."""
        return f"eventually{_words(self.within)} ({self.eventually.describe()})"


class UpTo(Part):
    """A formula holds until another one does, within a window of future time; *within* is as in `always`."""

    hold: FormulaPart
    until: FormulaPart
    within: _Window | None = None

    def describe(self) -> str:
        """Return the formula in words."""
        return f"({self.hold.describe()}) until{_words(self.within)} ({self.until.describe()})"


class Every(Part):
    """All of some formulas hold."""

    all: tuple[FormulaPart, ...] = Field(min_length=1)

    def describe(self) -> str:
        """Return the formula in words."""
        return " and ".join(part.describe() for part in self.all)


class AnyOne(Part):
    """At least one of some formulas holds."""

    any: tuple[FormulaPart, ...] = Field(min_length=1)

    def describe(self) -> str:
        """Return the formula in words."""
        return " or ".join(part.describe() for part in self.any)


class Opposite(Part):
    """A formula does not hold."""

    not_: FormulaPart = Field(alias="not")

    def describe(self) -> str:
        """Return the formula in words."""
        return f"not ({self.not_.describe()})"


class Conditional(Part):
    """If one formula holds, another holds too."""

    if_: FormulaPart = Field(alias="if")
    then: FormulaPart

    def describe(self) -> str:
        """Return the formula in words."""
        return f"if {self.if_.describe()} then {self.then.describe()}"


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

if TYPE_CHECKING:
    FormulaPart = Throughout | Sometime | UpTo | Conditional | Every | AnyOne | Opposite | Condition
else:
    _keys = f"has a key of {', '.join([*FORMULAS][:7])}, or is a condition"
    FormulaPart = one_of(FORMULAS, "formula", "a formula or a condition", _keys)
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
