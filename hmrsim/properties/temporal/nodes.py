"""Nodes of a formula that is monitored: each takes samples, and tells the changes of its value that are certain.

A change is a time and the value from then on, up to the next change. All values begin at the first sample.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Final

Change = tuple[Any, float]
Changes = Sequence[Change]

NEVER: Final = -math.inf
"""Before all times."""

JUST: Final = 1e-12
"""The distance from a bound of a value that equals it, and so is neither above nor below."""


def after(at: Any) -> Any:
    """Return the first time after a time."""
    return at + 1 if isinstance(at, int) else math.nextafter(at, math.inf)


class Node:
    """The base of nodes.

    Attributes:
        known: Up to which time its value is certain, that included.
    """

    known: Any = NEVER

    def step(self, at: Any, values: Sequence[float]) -> Changes:
        """Return the changes that are certain now that the signals have some values at a time."""
        raise NotImplementedError

    def close(self, at: Any, sign: float) -> Changes:
        """Return all further changes, at the end of all samples.

        Args:
            at: The time of the end; unbounded windows end there.
            sign: 1 for the greatest values that may follow, -1 for the least.
        """
        raise NotImplementedError


class Windowed(Node):
    """The base of nodes whose value at a time is that of a window ahead, up to its last change.

    Windows begin before the first sample does: what they hold up to then makes the first value.
    """

    def __init__(self) -> None:
        self._origin: Any = None
        self._begun = False
        self._value = math.nan

    def _tell(self, time: Any, value: float, made: list[Change]) -> None:
        """Add the change to a value from a time on to what was *made*, if it is one."""
        if time > self._origin:
            if not self._begun:
                self._begin(made)
            if value != self._value:
                made.append((time, value))
        self._value = value

    def _begin(self, made: list[Change]) -> None:
        """Add the first value."""
        self._begun = True
        made.append((self._origin, self._value))


class Instant(Node):
    """A formula without windows: its value at a time depends on the signals at that time."""

    def __init__(self, value: Callable[[Sequence[float]], float]) -> None:
        self._value = value
        self._last = math.nan

    def step(self, at: Any, values: Sequence[float]) -> Changes:
        """Return the change at this time, if there is one."""
        self.known = at
        value = self._value(values)
        if value == self._last:
            return ()
        self._last = value
        return ((at, value),)

    def close(self, at: Any, sign: float) -> Changes:
        """Return that nothing is known of what follows."""
        self.known = math.inf
        return ((after(at), sign * math.inf),)


class Negation(Node):
    """A formula does not hold."""

    def __init__(self, part: Node) -> None:
        self._part = part

    def step(self, at: Any, values: Sequence[float]) -> Changes:
        """Return the changes of the part, negated."""
        changes = self._part.step(at, values)
        self.known = self._part.known
        return [(time, -value) for time, value in changes]

    def close(self, at: Any, sign: float) -> Changes:
        """Return the rest of them."""
        self.known = math.inf
        return [(time, -value) for time, value in self._part.close(at, -sign)]


class Combination(Node):
    """The least of two values, or the greatest."""

    def __init__(self, left: Node, right: Node, *, least: bool) -> None:
        self._left, self._right = left, right
        self._least = least
        self._lefts: deque[Change] = deque()
        self._rights: deque[Change] = deque()
        self._last = self._left_value = self._right_value = math.nan

    def step(self, at: Any, values: Sequence[float]) -> Changes:
        """Return the changes up to where both are known."""
        left, right = self._left, self._right
        self._lefts.extend(left.step(at, values))
        self._rights.extend(right.step(at, values))
        self.known = left.known if left.known < right.known else right.known  # noqa: FURB136 - min() is slow
        return self._merged()

    def close(self, at: Any, sign: float) -> Changes:
        """Return the rest of them."""
        self._lefts.extend(self._left.close(at, sign))
        self._rights.extend(self._right.close(at, sign))
        self.known = math.inf
        return self._merged()

    def _merged(self) -> Changes:
        lefts, rights, known = self._lefts, self._rights, self.known
        made: list[Change] = []
        while lefts or rights:
            time = lefts[0][0] if lefts and (not rights or lefts[0][0] <= rights[0][0]) else rights[0][0]
            if time > known:
                break
            if lefts and lefts[0][0] == time:
                self._left_value = lefts.popleft()[1]
            if rights and rights[0][0] == time:
                self._right_value = rights.popleft()[1]
            one, other = self._left_value, self._right_value
            value = one if (one < other) is self._least else other
            if value != self._last:
                self._last = value
                made.append((time, value))
        return made
