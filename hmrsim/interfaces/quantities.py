"""The physical quantities of worlds, goals and services: each with its unit and the values that a simulation takes.

A field states its quantity in its type. Pydantic checks those of worlds, as in ``Annotated[float, SPEED.field]``, and
`flaw` those of ROS messages, ``Annotated[Float32, SPEED]``, whose types have no bounds of their own. Points need none:
one that is outside all maps is refused by what plans the way to it.
"""

from __future__ import annotations

from functools import cache
from operator import attrgetter
from typing import TYPE_CHECKING, Any, Final, NamedTuple, get_args

from pydantic import BaseModel, Field

if TYPE_CHECKING:
    from collections.abc import Callable


class Quantity(NamedTuple):
    """A physical quantity.

    Attributes:
        unit: Its unit; "units" is the world's unit of length.
        least: The least value; of one with a `sign`, the least magnitude.
        greatest: The greatest value, or magnitude.
        sign: Whether it may be negative, too.
        zero: Whether 0 is valid below `least`, such as a speed that stands for the robot's own.
    """

    unit: str
    least: float
    greatest: float
    sign: bool = False
    zero: bool = False

    def flaw(self, value: float) -> str:
        """Return what is wrong with a value; empty if nothing is."""
        size = abs(value) if self.sign else value
        if self.least <= size <= self.greatest or (self.zero and value == 0):
            return ""
        return f"{self._stated(value)} is not {self}"

    def checked(self, value: float) -> float:
        """Return a value that is valid.

        Raises:
            ValueError: It is not; the text says which values are.
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
        """The field of a world that has this quantity, for pydantic."""
        return Field(strict=True, ge=-self.greatest if self.sign else self.least, le=self.greatest)


ROTATION: Final = Quantity("", 0.0, 1e6, sign=True)
"""Of a component of a quaternion, which is normalized."""
ANGLE: Final = Quantity("rad", 0.0, 1e4, sign=True)
"""Of a turn: some 1,600 full ones."""
SPEED: Final = Quantity("units/s", 1e-9, 1e9)
SIGNED_SPEED: Final = Quantity("units/s", 1e-9, 1e9, sign=True, zero=True)
"""Of a goal: backwards, too, and 0 for the robot's own."""
ACCELERATION: Final = Quantity("units/s²", 1e-9, 1e9)
TURNING_RATE: Final = Quantity("rad/s", 1e-9, 1e9)
REAL_TIME_FACTOR: Final = Quantity("", 1e-6, 1e6, zero=True)
"""Simulated seconds a wall second; 0 is as fast as possible."""
SECONDS: Final = Quantity("s", 0.0, 1e9)
STEPS: Final = Quantity("", 0, 1e9)
"""Steps of a paused simulation, made at once."""


def flaw(message: BaseModel) -> str:
    """Return what is wrong with the first quantity of a message that is out of its range; empty if none is."""
    for path, read, quantity in _quantities(type(message)):
        if quantity is None:
            for number, each in enumerate(read(message)):
                if wrong := flaw(each):
                    return f"{path}.{number}.{wrong}"
        elif not quantity.least <= (value := read(message)) <= quantity.greatest and (wrong := quantity.flaw(value)):
            return f"{path}: {wrong}"
    return ""


@cache
def _quantities(kind: type[BaseModel]) -> list[tuple[str, Callable[[Any], Any], Quantity | None]]:
    """Return the path of each quantity of a message and what reads it; without a quantity, of a list of messages."""
    paths: list[tuple[str, Quantity | None]] = []
    for name, field in kind.model_fields.items():
        paths += [(name, each) for each in field.metadata if isinstance(each, Quantity)]
    for name, field in kind.model_fields.items():
        listed = get_args(field.annotation)
        inner = listed[0] if listed else field.annotation
        if isinstance(inner, type) and issubclass(inner, BaseModel) and (within := _quantities(inner)):
            paths += [(name, None)] if listed else [(f"{name}.{path}", quantity) for path, _, quantity in within]
    return [(path, attrgetter(path), quantity) for path, quantity in paths]
