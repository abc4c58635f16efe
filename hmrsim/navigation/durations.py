"""The durations of ways, by which routes are compared."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

from hmrsim.navigation.kept import Kept

if TYPE_CHECKING:
    from array import array

    from hmrsim.navigation.adjacency import Adjacency

_KEPT_SPEEDS = 16
"""Speeds for which it is kept how long each way takes."""


class Durations:
    """The seconds that ways count for: as long as they take, those that are avoided for longer.

    Args:
        ways: The ways.
        avoided: The numbers of those that are to be avoided.
        factor: How many times as long these count for.
    """

    def __init__(self, ways: Adjacency, avoided: Sequence[int] = (), factor: float = 1.0) -> None:
        self._ways = ways
        self._avoided, self._factor = avoided, factor
        self._kept: Kept[float, array[float]] = Kept(_KEPT_SPEEDS)

    def at(self, speed: float) -> array[float]:
        """Return how long each way counts for a robot of this greatest speed, by its number."""
        return self._kept.get(speed, lambda: self._counted(speed))

    def without(self, closed: Collection[int], speed: float) -> array[float]:
        """Return the same where some ways are closed: these take infinitely long."""
        seconds = self.at(speed)[:]
        for number in closed:
            seconds[number] = math.inf
        return seconds

    def _counted(self, speed: float) -> array[float]:
        seconds = self._ways.seconds(speed)
        for number in self._avoided:
            seconds[number] *= self._factor
        return seconds
