"""Monitors of formulas, which take one sample after the other."""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any

from hmrsim.properties.temporal.formulas import (
    Above,
    Always,
    And,
    Below,
    Eventually,
    Formula,
    Implies,
    Not,
    Or,
    Until,
)
from hmrsim.properties.temporal.nodes import JUST, Changes, Combination, Instant, Negation, Node
from hmrsim.properties.temporal.untils import UntilNode
from hmrsim.properties.temporal.windows import Extremum

_Value = Callable[[Sequence[float]], float]


class OnlineMonitor:
    """Tells the robustness of a formula at each time, as soon as it is certain.

    The signals have the values of a sample from its time up to the next one. What is told is exact at all times, those
    between samples included, and changes at the times that are told only.

    Args:
        formula: The formula.
        signals: The names of its signals, in the order of their values in samples.

    Raises:
        ValueError: It speaks of another signal.
    """

    def __init__(self, formula: Formula, signals: Sequence[str]) -> None:
        unknown = next((name for name in formula.signals() if name not in signals), None)
        if unknown is not None:
            raise ValueError(f"there is no signal {unknown!r}; there are {', '.join(signals)}")
        self._node = _node(formula, [*signals])
        self._at: Any = None

    @property
    def known(self) -> Any:
        """Up to which time its robustness is certain, that included; minus infinity if it is nowhere."""
        return self._node.known

    def update(self, at: Any, values: Sequence[float]) -> Changes:
        """Take the values of all signals from a time on.

        Returns:
            The changes of the robustness that are certain now and were not before: times and values, in order.

        Raises:
            ValueError: The time is not later than the last one.
        """
        if self._at is not None and at <= self._at:
            raise ValueError(f"a sample at {at!r} after one at {self._at!r}; expected a later one")
        self._at = at
        return self._node.step(at, values)

    def finish(self) -> tuple[Changes, Changes]:
        """Return the least and the greatest robustness that is possible at all further times, whatever would follow.

        Windows without an end end with the last sample: what never came there does not come any more.
        """
        if self._at is None:
            return (), ()
        return copy.deepcopy(self._node).close(self._at, -1.0), copy.deepcopy(self._node).close(self._at, 1.0)


def _node(formula: Formula, signals: list[str]) -> Node:
    """Return the node that monitors a formula."""
    value = _value(formula, signals)
    if value is not None:
        return Instant(value)
    parts = [_node(part, signals) for part in formula.parts]
    match formula:
        case Not():
            return Negation(parts[0])
        case And() | Or():
            return Combination(parts[0], parts[1], least=isinstance(formula, And))
        case Implies():
            return Combination(Negation(parts[0]), parts[1], least=False)
        case Always(start, end) | Eventually(start, end):
            return Extremum(parts[0], start, end, greatest=isinstance(formula, Eventually))
        case Until(start, end, left):
            until = UntilNode(parts[0], parts[1], end - start)
            # The left one holds up to the begin of the window, and from there the whole does.
            return until if not start else _shifted(until, _node(left, signals), start)
    raise TypeError(formula)


def _shifted(until: Node, left: Node, start: Any) -> Node:
    before = Extremum(left, 0, start, greatest=False)
    return Combination(before, Extremum(until, start, start, greatest=True), least=True)


def _value(formula: Formula, signals: list[str]) -> _Value | None:
    """Return the function of a sample that a formula without windows is; None if it has windows."""
    match formula:
        case Above(signal, bound):
            return _above(signals.index(signal), bound)
        case Below(signal, bound):
            return _below(signals.index(signal), bound)
    inner = [_value(part, signals) for part in formula.parts]
    known = [value for value in inner if value is not None]
    return _combined(formula, known) if len(known) == len(inner) else None


def _combined(formula: Formula, parts: list[_Value]) -> _Value | None:
    match formula, parts:
        case Not(), [part]:
            return lambda values: -part(values)
        case And(), [left, right]:
            return lambda values: min(left(values), right(values))
        case Or(), [left, right]:
            return lambda values: max(left(values), right(values))
        case Implies(), [left, right]:
            return lambda values: max(-left(values), right(values))
    return None


def _above(i: int, bound: float) -> _Value:
    if not bound:
        return lambda values: values[i] or -JUST
    return lambda values: values[i] - bound or -JUST


def _below(i: int, bound: float) -> _Value:
    return lambda values: bound - values[i] or -JUST
