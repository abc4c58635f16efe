"""Formulas of Signal Temporal Logic.

Times are in any unit that adds and compares, such as whole nanoseconds; windows include both of their ends.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass


class Formula:
    """The base of formulas."""

    @property
    def parts(self) -> tuple[Formula, ...]:
        """The formulas in it."""
        return ()

    @property
    def horizon(self) -> float:
        """How far ahead one has to look to know its value at a time."""
        return max((part.horizon for part in self.parts), default=0)

    def signals(self) -> Iterator[str]:
        """Yield the signals that it speaks of, each as often as it does."""
        for part in self.parts:
            yield from part.signals()


@dataclass(frozen=True)
class Above(Formula):
    """A signal is greater than a bound; its robustness is by how much."""

    signal: str
    bound: float = 0.0

    def signals(self) -> Iterator[str]:
        """Yield its signal."""
        yield self.signal


@dataclass(frozen=True)
class Below(Formula):
    """A signal is less than a bound; its robustness is by how much."""

    signal: str
    bound: float = 0.0

    def signals(self) -> Iterator[str]:
        """Yield its signal."""
        yield self.signal


@dataclass(frozen=True)
class Not(Formula):
    """A formula does not hold."""

    part: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        """The formula."""
        return (self.part,)


@dataclass(frozen=True)
class _Connective(Formula):
    """A formula about two formulas at the same time."""

    left: Formula
    right: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        """Both."""
        return (self.left, self.right)


@dataclass(frozen=True)
class And(_Connective):
    """Both of two formulas hold."""


@dataclass(frozen=True)
class Or(_Connective):
    """At least one of two formulas holds."""


@dataclass(frozen=True)
class Implies(_Connective):
    """If a formula holds, another one does."""


@dataclass(frozen=True)
class _Windowed(Formula):
    """A formula about a window ahead, from *start* to *end* after each time.

    Raises:
        ValueError: The window is none.
    """

    start: float
    end: float

    def __post_init__(self) -> None:
        """Check the window."""
        if not 0 <= self.start <= self.end or math.isinf(self.start):
            raise ValueError(f"a window from {self.start!r} to {self.end!r}; expected 0 <= start <= end")

    @property
    def horizon(self) -> float:
        """The end of the window, and what is beyond it."""
        return self.end + super().horizon


@dataclass(frozen=True)
class Always(_Windowed):
    """A formula holds at each time of a window; *end* may be infinite."""

    part: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        """The formula."""
        return (self.part,)


@dataclass(frozen=True)
class Eventually(_Windowed):
    """A formula holds at some time of a window; *end* may be infinite."""

    part: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        """The formula."""
        return (self.part,)


@dataclass(frozen=True)
class Until(_Windowed):
    """The right formula holds at some time of a window, and the left one from now to that time, that included."""

    left: Formula
    right: Formula

    @property
    def parts(self) -> tuple[Formula, ...]:
        """Both."""
        return (self.left, self.right)
