"""Until: one value has to stay high up to where another one is.

The value in a window is a fold of its spans: each is a function of what comes after it, the greatest of *here* and of
the least of *through* and what follows. Such functions can be composed, so a queue of two stacks folds a window that
slides at a constant cost on average.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Any

from hmrsim.properties.temporal.nodes import Change, Changes, Node, Windowed

_Span = tuple[float, float]
"""Here, through."""


def _then(first: _Span, second: _Span) -> _Span:
    """Return two spans as one."""
    here, through = first
    onward, beyond = second
    onward = onward if onward < through else through  # noqa: FURB136 - min() is slow
    return (here if here > onward else onward), (beyond if beyond < through else through)  # noqa: FURB136


_NOTHING: _Span = (-math.inf, math.inf)
"""The span that changes nothing."""


class UntilNode(Windowed):
    """The right value is high at some time of the window from now to *end* ahead, and the left one up to then.

    Args:
        end: May be infinite: the window then ends with all samples.
    """

    def __init__(self, left: Node, right: Node, end: Any) -> None:
        super().__init__()
        self._left, self._right, self._end = left, right, end
        self._lefts: deque[Change] = deque()
        self._rights: deque[Change] = deque()
        self._values = [math.nan, math.nan]
        self._front: list[_Span] = []
        self._back: list[_Span] = []
        self._behind = _NOTHING
        self._ends: deque[Any] = deque()

    def step(self, at: Any, values: Sequence[float]) -> Changes:
        """Return the changes of all times whose windows are known."""
        self._lefts.extend(self._left.step(at, values))
        self._rights.extend(self._right.step(at, values))
        known = min(self._left.known, self._right.known)
        made: list[Change] = []
        self._merge(known, made)
        self.known = known - self._end
        self._leave(self.known, made)
        return made

    def close(self, at: Any, sign: float) -> Changes:
        """Return the rest of them."""
        endless = self._end == math.inf
        self._lefts.extend(self._left.close(at, sign))
        self._rights.extend(self._right.close(at, sign))
        made: list[Change] = []
        self._merge(at if endless else math.inf, made)
        self.known = math.inf
        self._leave(at if endless else math.inf, made)
        return made

    def _merge(self, known: Any, made: list[Change]) -> None:
        lefts, rights = self._lefts, self._rights
        while lefts or rights:
            time = min(changes[0][0] for changes in (lefts, rights) if changes)
            if time > known:
                break
            for i, changes in enumerate((lefts, rights)):
                if changes and changes[0][0] == time:
                    self._values[i] = changes.popleft()[1]
            self._enter(time, made)

    def _enter(self, time: Any, made: list[Change]) -> None:
        now = time - self._end
        if self._origin is None:
            self._origin = time
        else:
            self._ends.append(time)
        while self._ends and self._ends[0] <= now:
            left = self._drop()
            if left < now:
                self._tell(left, self._whole(), made)
        through, right = self._values
        span = (min(through, right), through)
        self._back.append(span)
        self._behind = _then(self._behind, span)
        self._tell(now, self._whole(), made)

    def _drop(self) -> Any:
        """Drop the first span of the window; return when it was left."""
        if not self._front:
            self._front, self._back = self._folded(), []
            self._behind = _NOTHING
        self._front.pop()
        return self._ends.popleft()

    def _folded(self) -> list[_Span]:
        """Return the spans behind, the first one last, each with all after it."""
        folded: list[_Span] = []
        after = _NOTHING
        for span in reversed(self._back):
            after = _then(span, after)
            folded.append(after)
        return folded

    def _leave(self, now: Any, made: list[Change]) -> None:
        if not self._begun and self._origin is not None and now >= self._origin:
            self._value = self._whole()
            self._begin(made)
        while self._ends and self._ends[0] <= now:
            self._tell(self._drop(), self._whole(), made)

    def _whole(self) -> float:
        return _then(self._front[-1], self._behind)[0] if self._front else self._behind[0]
