"""A priority queue of tick times."""

from __future__ import annotations

import math
from heapq import heappop, heappush

from bt_controller.core.sim_time import NANOSECONDS, nanoseconds


class TimerQueue:
    """A time for each number, in simulated seconds; infinite for never, the initial value."""

    def __init__(self) -> None:
        self._times: dict[int, int] = {}
        # All times that were ever put; replaced ones are skipped when they come up.
        self._heap: list[tuple[int, int]] = []

    def put(self, who: int, time: float) -> None:
        """Set the time of a number, replacing any earlier one."""
        if time == math.inf:
            self._times.pop(who, None)
        elif self._times.get(who) != (whole := nanoseconds(time)):
            self._times[who] = whole
            heappush(self._heap, (whole, who))

    @property
    def earliest(self) -> float:
        """The earliest time."""
        while self._heap and self._times.get(self._heap[0][1]) != self._heap[0][0]:
            heappop(self._heap)
        return self._heap[0][0] / NANOSECONDS if self._heap else math.inf

    def pop_due(self, now: float) -> list[int]:
        """Return and remove the numbers that are due."""
        come = []
        while self.earliest <= nanoseconds(now) / NANOSECONDS:
            come.append(heappop(self._heap)[1])
            del self._times[come[-1]]
        return come
