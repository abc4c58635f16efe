"""The physical quantities of worlds, goals and services, each with its unit and its valid range.

A field states its quantity in its type. Pydantic checks the fields of worlds, as in ``Annotated[float, SPEED.field]``.
`flaw` checks those of ROS messages, as in ``Annotated[Float32, SPEED]``, because ROS types have no bounds. Points need
none: planning rejects a point outside all maps.
"""

from __future__ import annotations

from functools import cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeAlias, get_args

from pydantic import BaseModel, Field

if TYPE_CHECKING:
    from collections.abc import Callable


class Quantity(NamedTuple):
    """A physical quantity, with its unit and range.

    Attributes:
        unit: Its unit; "units" is the world's unit of length.
        least: The minimum or, with a `sign`, the minimum magnitude.
        greatest: The maximum or, with a `sign`, the maximum magnitude.
        sign: Whether the value may be negative.
        zero: Whether 0 is valid even if it is below `least`; a speed of 0 means the robot's own speed.
    """

    unit: str
    least: float
    greatest: float
    sign: bool = False
    zero: bool = False

    def flaw(self, value: float) -> str:
        """Return why a value is invalid, or an empty text."""
        size = abs(value) if self.sign else value
        if self.least <= size <= self.greatest or (self.zero and value == 0):
            return ""
        return f"{self._stated(value)} is not {self}"

    def checked(self, value: float) -> float:
        """Return the value if it is valid.

        Raises:
            ValueError: It is not; the message gives the valid range.
        """
        if wrong := self.flaw(value):
            raise ValueError(wrong)
        return value

    def __str__(self) -> str:
        """Return the valid values, such as ``from 0 to 1e+09 s``."""
        greatest = self._stated(self.greatest)
        if self.sign and not self.least:
            return f"from {-self.greatest:g} to {greatest}"
        return f"{'0, or ' if self.zero else ''}from {self.least:g} to {greatest}{', or its negative' * self.sign}"

    def _stated(self, value: float) -> str:
        return f"{value:g} {self.unit}".rstrip()

    @property
    def field(self) -> Any:
        """A pydantic field that checks the range."""
        return Field(strict=True, ge=-self.greatest if self.sign else self.least, le=self.greatest)


ROTATION: Final = Quantity("", 0.0, 1e6, sign=True)
"""A component of a quaternion, before normalization."""
ANGLE: Final = Quantity("rad", 0.0, 1e4, sign=True)
"""An angle to turn by: about 1,600 full turns at most."""
SPEED: Final = Quantity("units/s", 1e-9, 1e9)
SIGNED_SPEED: Final = Quantity("units/s", 1e-9, 1e9, sign=True, zero=True)
"""The speed of a goal: negative to drive backwards, 0 for the robot's own speed."""
ACCELERATION: Final = Quantity("units/s²", 1e-9, 1e9)
TURNING_RATE: Final = Quantity("rad/s", 1e-9, 1e9)
REAL_TIME_FACTOR: Final = Quantity("", 1e-6, 1e6, zero=True)
"""Simulated seconds per wall second; 0 is as fast as possible."""
SECONDS: Final = Quantity("s", 0.0, 1e9)
STEPS: Final = Quantity("", 0, 1e9)
"""Steps by which a paused simulation advances."""


def flaw(message: BaseModel) -> str:
    """Return why the first invalid quantity of a message is out of range, or an empty text."""
    given = message.__pydantic_fields_set__
    for name, quantities, of_default in _fields(type(message)):
        if wrong := _first_flaw(message, quantities) if name in given else of_default:
            return wrong
    return ""


_Quantities: TypeAlias = "list[tuple[str, Callable[[Any], Any], Quantity | None]]"
"""Path and getter of each quantity in a message; a list of messages has no quantity itself."""


def _first_flaw(message: BaseModel, quantities: _Quantities) -> str:
    for path, read, quantity in quantities:
        if quantity is None:
            for number, item in enumerate(read(message)):
                if wrong := flaw(item):
                    return f"{path}.{number}.{wrong}"
        elif not quantity.least <= (value := read(message)) <= quantity.greatest and (wrong := quantity.flaw(value)):
            return f"{path}: {wrong}"
    return ""


@cache
def _fields(kind: type[BaseModel]) -> list[tuple[str, _Quantities, str]]:
    """Return the fields of a message that have quantities, its own first, each with the flaw of its default, if any."""
    fields: dict[str, _Quantities] = {}
    for found in _quantities(kind):
        fields.setdefault(found[0].partition(".")[0], []).append(found)
    blank, given = kind.model_construct(), {name for name, each in kind.model_fields.items() if each.is_required()}
    return [(name, found, "" if name in given else _first_flaw(blank, found)) for name, found in fields.items()]


@cache
def _quantities(kind: type[BaseModel]) -> _Quantities:
    paths: list[tuple[str, Quantity | None]] = []
    for name, field in kind.model_fields.items():
        paths += [(name, mark) for mark in field.metadata if isinstance(mark, Quantity)]
    for name, field in kind.model_fields.items():
        listed = get_args(field.annotation)
        inner = listed[0] if listed else field.annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel) and (within := _quantities(inner)):
            paths += [(name, None)] if listed else [(f"{name}.{path}", quantity) for path, _, quantity in within]
    return [(path, attrgetter(path), quantity) for path, quantity in paths]
