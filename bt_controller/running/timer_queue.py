"""A priority queue of tick times."""

from __future__ import annotations

import math
from heapq import heappop, heappush

from bt_controller.core.sim_time import NANOSECONDS, nanoseconds


class Agenda:
    """A time for each of some numbers, in simulated seconds; infinite for never, as at first."""

    def __init__(self) -> None:
        self._times: dict[int, int] = {}
        # All times that were ever put; those that were put off are passed over when they come up.
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

    def take(self, now: float) -> list[int]:
        """Return whose time has come; they have none until one is put."""
        come = []
        while self.earliest <= nanoseconds(now) / NANOSECONDS:
            come.append(heappop(self._heap)[1])
            del self._times[come[-1]]
        return come
