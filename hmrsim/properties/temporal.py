"""The temporal engine: formulas over signals that are constant between changes, monitored sample by sample.

Formulas look ahead, in windows of time (Signal Temporal Logic), or back, from one sample to those before it (past-time
temporal logic). Values are robustness: positive where a formula holds, negative where it does not, and the further from
zero the surer. Each sample costs a constant time on average, however long the windows are.

Times are in any unit that adds and compares, such as whole nanoseconds; windows include both of their ends.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

from hmrsim.properties.robustness import JUST, Changes, Combination, Extremum, Instant, Negation, Node, UntilNode

Value = Callable[[Sequence[float]], float]
"""Returns the robustness of a formula at a sample; it is called with each sample in turn."""


class Formula:
    """The base class of temporal formulas."""

    @property
    def parts(self) -> tuple[Formula, ...]:
        """The operands of this formula."""
        return tuple(value for value in vars(self).values() if isinstance(value, Formula))

    @property
    def horizon(self) -> float:
        """The length of the future on which the value at a sample depends, in the unit of the windows."""
        return max((part.horizon for part in self.parts), default=0)

    @property
    def has_windows(self) -> bool:
        """True if the formula contains a window of future time."""
        return any(part.has_windows for part in self.parts)

    def value(self, signals: Sequence[str]) -> Value:
        """Return the function that computes its robustness at each sample, given the order of signals in samples.

        Raises:
            ValueError: The formula contains a window.
        """
        if isinstance(self, Above):
            return _above(signals.index(self.signal), self.bound)
        make = _VALUES.get(type(self))
        if make is None:
            raise ValueError(f"{self} is inside of a formula without windows")
        parts = [part.value(signals) for part in self.parts]
        return make(parts[0], parts[-1], math.inf if getattr(self, "initially", False) else -math.inf)

    def signals(self) -> Iterator[str]:
        """Yield the names of the signals of the formula, with repetitions."""
        for part in self.parts:
            yield from part.signals()


def _above(i: int, bound: float) -> Value:
    return (lambda values: values[i] - bound or -JUST) if bound else lambda values: values[i] or -JUST


@dataclass(frozen=True)
class Above(Formula):
    """A signal is greater than a bound; its robustness is by how much."""

    signal: str
    bound: float = 0.0

    def signals(self) -> Iterator[str]:
        """Yield the signal."""
        yield self.signal


@dataclass(frozen=True)
class Not(Formula):
    """A formula does not hold."""

    part: Formula


@dataclass(frozen=True)
class And(Formula):
    """Both of two formulas hold."""

    left: Formula
    right: Formula


@dataclass(frozen=True)
class Or(Formula):
    """At least one of two formulas holds."""

    left: Formula
    right: Formula


@dataclass(frozen=True)
class Implies(Formula):
    """If one formula holds, another holds too."""

    left: Formula
    right: Formula


@dataclass(frozen=True)
class _Windowed(Formula):
    """A formula about a window ahead, from *start* to *end* after each time; *end* may be infinite.

    Raises:
        ValueError: The window ends before it begins.
    """

    start: float
    end: float

    def __post_init__(self) -> None:
        """Check the window."""
        if not 0 <= self.start <= self.end or math.isinf(self.start):
            raise ValueError(f"a window from {self.start!r} to {self.end!r}; expected 0 <= start <= end")

    @property
    def horizon(self) -> float:
        """The end of the window plus the horizon of the operands."""
        return self.end + super().horizon

    @property
    def has_windows(self) -> bool:
        """True: the formula is a window of future time."""
        return True


@dataclass(frozen=True)
class Always(_Windowed):
    """A formula holds at each time of a window."""

    part: Formula


@dataclass(frozen=True)
class Eventually(_Windowed):
    """A formula holds at some time of a window."""

    part: Formula


@dataclass(frozen=True)
class Until(_Windowed):
    """The right formula holds at some time of a window, and the left one from now to that time, that included."""

    left: Formula
    right: Formula


@dataclass(frozen=True)
class Previous(Formula):
    """A formula without windows held at the sample before; at the first sample it counts as *initially*."""

    part: Formula
    initially: bool = False


@dataclass(frozen=True)
class Since(Formula):
    """The right formula held at some sample so far, and the left one at all samples since.

    Both are without windows. Before the first sample it counts as *initially*.
    """

    left: Formula
    right: Formula
    initially: bool = False


@dataclass(frozen=True)
class Once(Formula):
    """A formula without windows holds, or held at some sample before."""

    part: Formula


def _previous(part: Value, _part: Value, last: float) -> Value:
    def value(values: Sequence[float]) -> float:
        nonlocal last
        before, last = last, part(values)
        return before

    return value


def _since(left: Value, right: Value, last: float) -> Value:
    def value(values: Sequence[float]) -> float:
        nonlocal last
        last = max(right(values), min(left(values), last))
        return last

    return value


_VALUES: Final[Mapping[type[Formula], Callable[[Value, Value, float], Value]]] = {
    Not: lambda part, _part, _last: lambda values: -part(values),
    And: lambda left, right, _last: lambda values: min(left(values), right(values)),
    Or: lambda left, right, _last: lambda values: max(left(values), right(values)),
    Implies: lambda left, right, _last: lambda values: max(-left(values), right(values)),
    Previous: _previous,
    Since: _since,
    Once: lambda part, _part, last: _since(lambda _values: math.inf, part, last),
}
"""The functions of operands, and of the value before the first sample, by the type of formula."""


class OnlineMonitor:
    """Computes the robustness of a formula at each time as soon as it is certain.

    The signals keep the values of a sample up to the next one. The robustness is exact at all times, also between
    samples: it changes at the times that are returned and nowhere else.

    Args:
        signals: The names of its signals, in the order of their values in samples.

    Raises:
        ValueError: It has another signal.
    """

    def __init__(self, formula: Formula, signals: Sequence[str]) -> None:
        unknown = next((name for name in formula.signals() if name not in signals), None)
        if unknown is not None:
            raise ValueError(f"there is no signal {unknown!r}; there are {', '.join(signals)}")
        self._node = _node(formula, signals)
        self._at: Any = None

    @property
    def known(self) -> Any:
        """The last time at which the robustness is certain; minus infinity if there is none."""
        return self._node.known

    def update(self, at: Any, values: Sequence[float]) -> Changes:
        """Take the values of all signals from a time on.

        Returns:
            The changes of the robustness that have become certain: times and values, in order.

        Raises:
            ValueError: The time is not later than the last one.
        """
        if self._at is not None and at <= self._at:
            raise ValueError(f"a sample at {at!r} after one at {self._at!r}; expected a later one")
        self._at = at
        return self._node.step(at, values)

    def finish(self) -> tuple[Changes, Changes]:
        """Return the least and the greatest possible robustness at all remaining times.

        Windows without an end end with the last sample.
        """
        if self._at is None:
            return (), ()
        return copy.deepcopy(self._node).close(self._at, -1.0), copy.deepcopy(self._node).close(self._at, 1.0)


def _node(formula: Formula, signals: Sequence[str]) -> Node:
    if not formula.has_windows:
        return Instant(formula.value(signals))
    parts = [_node(part, signals) for part in formula.parts]
    match formula:
        case Not():
            return Negation(parts[0])
        case And() | Or() | Implies():
            left = Negation(parts[0]) if isinstance(formula, Implies) else parts[0]
            return Combination(left, parts[1], least=isinstance(formula, And))
        case Always(start, end) | Eventually(start, end):
            return Extremum(parts[0], start, end, greatest=isinstance(formula, Eventually))
        case Until(start, end, held):
            until = UntilNode(parts[0], parts[1], end - start)
            return until if not start else _delayed(until, _node(held, signals), start)
    return Instant(formula.value(signals))


def _delayed(until: Node, left: Node, start: Any) -> Node:
    """Return an "until" whose window begins later: the left formula holds up to there, and then the whole."""
    before = Extremum(left, 0, start, greatest=False)
    return Combination(before, Extremum(until, start, start, greatest=True), least=True)
