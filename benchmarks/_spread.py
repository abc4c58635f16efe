"""The spread of several rounds of one measurement."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from typing import Self


class Spread(float):
    """The median of some rounds as a number, with the minimum and the maximum."""

    least: float
    most: float

    def __new__(cls, median: float, least: float, most: float) -> Self:
        """Return a spread by its three numbers."""
        spread = super().__new__(cls, median)
        spread.least, spread.most = least, most
        return spread

    @classmethod
    def of(cls, rounds: Iterable[float]) -> Self:
        """Return the spread of the results of rounds, one number per round."""
        given = sorted(rounds)
        return cls(statistics.median(given), given[0], given[-1])

    def __getnewargs__(self) -> tuple[float, float, float]:  # type: ignore[override]
        """Return the arguments that a copy is created with."""
        return float(self), self.least, self.most
