"""Always and eventually: the least and the greatest value in a window that slides, by a monotonic queue (Lemire)."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Sequence
from typing import Any

from hmrsim.properties.temporal.nodes import Change, Changes, Node, Windowed


class Extremum(Windowed):
    """The extremum of a value in the window from *start* to *end* ahead, both included.

    The queue has the spans of the value in the window, but for those that a later one outdoes: a span is entered when
    the window reaches its begin, and left when the window has passed its end.

    Args:
        start: May be infinite, as *end*: such a window ends with all samples.
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
        made: list[Change] = []
        for time, value in part.step(at, values):
            self._enter(time, value, end, made)
        if end != math.inf:
            self.known = known = part.known - end
            queue = self._queue
            if queue and (queue[0][0] <= known or (not self._begun and known >= self._origin)):
                self._leave(known, made)
        return made

    def close(self, at: Any, sign: float) -> Changes:
        """Return the rest of them; of a window without an end only what has been seen counts."""
        made: list[Change] = []
        endless = self._end == math.inf
        for time, value in self._part.close(at, sign):
            if not endless or time <= at:
                self._enter(time, value, self._end, made)
        self.known = math.inf
        self._leave(at if endless else math.inf, made)
        return made

    def _enter(self, time: Any, value: float, end: Any, made: list[Change]) -> None:
        queue, value = self._queue, self._sign * value
        if self._origin is None:
            self._origin = time
        now = time - end
        self._open[0] = time - self._start
        while queue and queue[0][0] <= now:
            left = queue.popleft()[0]
            if left < now:
                self._tell(left, self._sign * queue[0][1], made)
        while queue and queue[-1][1] <= value:
            queue.pop()
        self._open = [math.inf, value]
        queue.append(self._open)
        self._tell(now, self._sign * queue[0][1], made)

    def _leave(self, now: Any, made: list[Change]) -> None:
        queue = self._queue
        if not self._begun and queue and now >= self._origin:
            while queue[0][0] <= self._origin:
                queue.popleft()
                self._value = self._sign * queue[0][1]
            self._begin(made)
        while queue and queue[0][0] <= now:
            left = queue.popleft()[0]
            if queue:
                self._tell(left, self._sign * queue[0][1], made)
