"""What several rounds of one measurement gave."""

from __future__ import annotations

import statistics
from collections.abc import Iterable
from typing import Self


class Spread(float):
    """The median of some rounds, which is its value as a number, with the least and the most of them."""

    least: float
    most: float

    def __new__(cls, median: float, least: float, most: float) -> Self:
        """Return it by its three numbers."""
        spread = super().__new__(cls, median)
        spread.least, spread.most = least, most
        return spread

    @classmethod
    def of(cls, rounds: Iterable[float]) -> Self:
        """Return the spread of what rounds gave, one number a round."""
        given = sorted(rounds)
        return cls(statistics.median(given), given[0], given[-1])

    def __getnewargs__(self) -> tuple[float, float, float]:  # type: ignore[override]
        """Return what a copy is made of."""
        return float(self), self.least, self.most
