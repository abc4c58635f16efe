"""The nodes of a monitored formula: each takes samples and returns the changes of its robustness that are certain.

A change is a time and the value from then on, up to the next change. All values begin at the first sample.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any, Final

Change = tuple[Any, float]
Changes = Sequence[Change]

JUST: Final = 1e-12
"""The distance from a bound of a value that equals it, and so is neither above nor below."""


class Node:
    """The base class of the nodes that compute robustness.

    Attributes:
        known: The last time at which its value is certain.
    """

    known: Any = -math.inf

    def step(self, at: Any, values: Sequence[float]) -> Changes:
        """Return the changes that are certain once the signals have some values at a time."""
        raise NotImplementedError

    def close(self, at: Any, sign: float) -> Changes:
        """Return all further changes, after the last sample.

        Args:
            at: The time of the last sample; unbounded windows end there.
            sign: 1 for the greatest values that may follow, -1 for the least.
        """
        raise NotImplementedError


class Instant(Node):
    """A formula without windows: its value is a function of the samples up to a time."""

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
        """Return the extreme value from the first time after the last sample on."""
        self.known = math.inf
        return ((at + 1 if isinstance(at, int) else math.nextafter(at, math.inf), sign * math.inf),)


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


class _Pair:
    """The changes of two values, merged in order of time."""

    def __init__(self) -> None:
        self._lefts: deque[Change] = deque()
        self._rights: deque[Change] = deque()
        self._values = (math.nan, math.nan)

    def merge(self, new_lefts: Changes, new_rights: Changes, until: Any) -> list[tuple[Any, float, float]]:
        """Add changes of both; return the times of all changes up to a time, with both values from then on."""
        lefts, rights = self._lefts, self._rights
        lefts.extend(new_lefts)
        rights.extend(new_rights)
        left, right = self._values
        changes = []
        while lefts or rights:
            time = lefts[0][0] if lefts and (not rights or lefts[0][0] <= rights[0][0]) else rights[0][0]
            if time > until:
                break
            if lefts and lefts[0][0] == time:
                left = lefts.popleft()[1]
            if rights and rights[0][0] == time:
                right = rights.popleft()[1]
            changes.append((time, left, right))
        self._values = left, right
        return changes


class Combination(Node):
    """The least of two values, or the greatest."""

    def __init__(self, left: Node, right: Node, *, least: bool) -> None:
        self._left, self._right = left, right
        self._pair = _Pair()
        self._least = least
        self._last = math.nan

    def step(self, at: Any, values: Sequence[float]) -> Changes:
        """Return the changes up to where both are known."""
        left, right = self._left, self._right
        lefts, rights = left.step(at, values), right.step(at, values)
        self.known = left.known if left.known < right.known else right.known  # noqa: FURB136 - min() is slow
        return self._combined(lefts, rights)

    def close(self, at: Any, sign: float) -> Changes:
        """Return the rest of them."""
        self.known = math.inf
        return self._combined(self._left.close(at, sign), self._right.close(at, sign))

    def _combined(self, lefts: Changes, rights: Changes) -> Changes:
        changes: list[Change] = []
        for time, left, right in self._pair.merge(lefts, rights, self.known):
            value = left if (left < right) is self._least else right
            if value != self._last:
                self._last = value
                changes.append((time, value))
        return changes


class _Windowed(Node):
    """The base class of nodes whose value at a time depends on a window of future time.

    Windows begin before the first sample does: the values in them up to then make the first value.
    """

    def __init__(self) -> None:
        self._origin: Any = None
        self._begun = False
        self._value = math.nan

    def _add(self, time: Any, value: float, changes: list[Change]) -> None:
        """Add the change to a value from a time on, if it is one."""
        if time > self._origin:
            if not self._begun:
                self._begin(changes)
            if value != self._value:
                changes.append((time, value))
        self._value = value

    def _begin(self, changes: list[Change]) -> None:
        """Add the first value."""
        self._begun = True
        changes.append((self._origin, self._value))


class Extremum(_Windowed):
    """Always and eventually: the extremum of a value in the window from *start* to *end* ahead, both included.

    A monotonic queue (Lemire) has the spans of the value in the window, except those that a later one outdoes: a span
    is entered when the window reaches its begin, and left when the window has passed its end.

    Args:
        end: May be infinite: the window then ends with the last sample.
        greatest: Whether it is the greatest value, as of eventually; else it is the least one, as of always.
    """

    def __init__(self, part: Node, start: Any, end: Any, *, greatest: bool) -> None:
        super().__init__()
        self._part = part
        self._start, self._end = start, end
        self._sign = 1.0 if greatest else -1.0
        self._queue: deque[list[Any]] = deque()
        self._open: list[Any] = [math.inf, math.nan]

    def step(self, at: Any, values: Sequence[float]) -> Changes:
        """Return the changes of all times whose windows are known."""
        part, end = self._part, self._end
        changes: list[Change] = []
        for time, value in part.step(at, values):
            self._enter(time, value, end, changes)
        if end != math.inf:
            self.known = known = part.known - end
            queue = self._queue
            if queue and (queue[0][0] <= known or (not self._begun and known >= self._origin)):
                self._leave(known, changes)
        return changes

    def close(self, at: Any, sign: float) -> Changes:
        """Return the rest of them; a window without an end ends with the last sample."""
        changes: list[Change] = []
        endless = self._end == math.inf
        for time, value in self._part.close(at, sign):
            if not endless or time <= at:
                self._enter(time, value, self._end, changes)
        self.known = math.inf
        self._leave(at if endless else math.inf, changes)
        return changes

    def _enter(self, time: Any, value: float, end: Any, changes: list[Change]) -> None:
        queue, value = self._queue, self._sign * value
        if self._origin is None:
            self._origin = time
        now = time - end
        self._open[0] = time - self._start
        while queue and queue[0][0] <= now:
            left = queue.popleft()[0]
            if left < now:
                self._add(left, self._sign * queue[0][1], changes)
        while queue and queue[-1][1] <= value:
            queue.pop()
        self._open = [math.inf, value]
        queue.append(self._open)
        self._add(now, self._sign * queue[0][1], changes)

    def _leave(self, now: Any, changes: list[Change]) -> None:
        queue = self._queue
        if not self._begun and queue and now >= self._origin:
            while queue[0][0] <= self._origin:
                queue.popleft()
                self._value = self._sign * queue[0][1]
            self._begin(changes)
        while queue and queue[0][0] <= now:
            left = queue.popleft()[0]
            if queue:
                self._add(left, self._sign * queue[0][1], changes)


_Span = tuple[float, float]
"""A span of an until as a function of what follows it: the greatest of the first value and of the least of the second
value and what follows."""

_NOTHING: _Span = (-math.inf, math.inf)
"""The span that changes nothing."""


def _then(first: _Span, second: _Span) -> _Span:
    """Return two spans as one."""
    here, through = first
    onward, beyond = second
    onward = onward if onward < through else through  # noqa: FURB136 - min() is slow
    return (here if here > onward else onward), (beyond if beyond < through else through)  # noqa: FURB136


class UntilNode(_Windowed):
    """The right value is high at some time of the window from now to *end* ahead, and the left one up to then.

    The spans of the window can be composed, so that a queue of two stacks folds it at a constant cost on average.

    Args:
        end: May be infinite: the window then ends with the last sample.
    """

    def __init__(self, left: Node, right: Node, end: Any) -> None:
        super().__init__()
        self._left, self._right, self._end = left, right, end
        self._pair = _Pair()
        self._front: list[_Span] = []
        self._back: list[_Span] = []
        self._behind = _NOTHING
        self._ends: deque[Any] = deque()

    def step(self, at: Any, values: Sequence[float]) -> Changes:
        """Return the changes of all times whose windows are known."""
        lefts, rights = self._left.step(at, values), self._right.step(at, values)
        known = min(self._left.known, self._right.known)
        self.known = known - self._end
        return self._slide(lefts, rights, known, self.known)

    def close(self, at: Any, sign: float) -> Changes:
        """Return the rest of them."""
        until = at if self._end == math.inf else math.inf
        self.known = math.inf
        return self._slide(self._left.close(at, sign), self._right.close(at, sign), until, until)

    def _slide(self, lefts: Changes, rights: Changes, known: Any, now: Any) -> Changes:
        changes: list[Change] = []
        for time, left, right in self._pair.merge(lefts, rights, known):
            self._enter(time, left, right, changes)
        self._leave(now, changes)
        return changes

    def _enter(self, time: Any, left: float, right: float, changes: list[Change]) -> None:
        now = time - self._end
        if self._origin is None:
            self._origin = time
        else:
            self._ends.append(time)
        while self._ends and self._ends[0] <= now:
            end = self._drop()
            if end < now:
                self._add(end, self._whole(), changes)
        span = (min(left, right), left)
        self._back.append(span)
        self._behind = _then(self._behind, span)
        self._add(now, self._whole(), changes)

    def _drop(self) -> Any:
        """Drop the first span of the window; return when it was left."""
        if not self._front:
            after = _NOTHING
            for span in reversed(self._back):
                after = _then(span, after)
                self._front.append(after)
            self._back, self._behind = [], _NOTHING
        self._front.pop()
        return self._ends.popleft()

    def _leave(self, now: Any, changes: list[Change]) -> None:
        if not self._begun and self._origin is not None and now >= self._origin:
            self._value = self._whole()
            self._begin(changes)
        while self._ends and self._ends[0] <= now:
            self._add(self._drop(), self._whole(), changes)

    def _whole(self) -> float:
        return _then(self._front[-1], self._behind)[0] if self._front else self._behind[0]
