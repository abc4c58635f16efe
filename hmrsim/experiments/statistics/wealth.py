"""Wealth of a gambler who bets, at fair odds, that paired differences lie above a value.

If their mean is the value, or below it, no way of betting makes money: the wealth, which is 1 at first, is a
nonnegative supermartingale, and reaches 1 / alpha at any time with probability alpha at most (Ville, Étude critique de
la notion de collectif, 1939). So one may look at it after each pair. It is a mixture over stakes, as nobody knows
beforehand how large the difference is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Final, Protocol, TypeAlias, cast

from hmrsim.experiments.statistics.libraries import arrays, log_normal_probability
from hmrsim.experiments.statistics.moments import asymmetries, finite

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Array: TypeAlias = "NDArray[np.float64]"

FIRST_LOOK: Final = 30
"""Differences of real numbers before which nothing is said."""

_PRIOR: Final = 1 / 5
"""The stakes' variance is the inverse of this share of the first sum of squares. The larger it is, the later small
differences are found, and the sooner large ones; with a fifth, those soonest for which fifty differences are enough."""

_CAUTION: Final = 12.0
"""By how many standard deviations the sum of the differences is reduced for each unit of skewness against the gambler.
The first term of the Edgeworth expansion, at the three standard errors that a verdict takes, is (2 * 3² + 1) / 6, a
quarter of this; but some tens of values rarely show how skewed their distribution is. The table of false verdicts in
docs/reference/statistics.md says what it comes to."""

_SHARES: Final = (1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 3 / 4, 15 / 16)
"""For yes or no: shares of the wealth that the least difference would lose."""


class Bets(Protocol):
    """Bets on some differences in their order."""

    def log_wealth(self, value: float) -> Array:
        """Return the logarithm of the wealth after each difference, of betting that they lie above the value.

        It falls as the value rises.
        """


class RealBets:
    """Bets on differences of real numbers.

    A stake of λ multiplies the wealth by exp(λ (d - value) - λ² (d - value)² / 2), so that it depends on the sum and
    the sum of squares of all d - value alone; the mixture over λ, which is half-normal, has a closed form. If d is
    distributed symmetrically about the value, whatever its tails, and whatever came before, the factor is 1 at most on
    average: it is never more than 1 + tanh(λ (d - value)). That stays true if the spread of λ depends on the sizes of
    d - value, which say nothing about their signs: it follows from those of the first 30. Two controllers that do the
    same have symmetrical differences, as each could as well have been the other.

    Of other differences the level is that of a normal approximation, as precise as Student's t with so many pairs.
    That is too many false verdicts where they are skewed: most differences are on one side of their mean, and the few
    large ones that make up for it have not come yet. So no wealth is told before the 30th difference, nor while all
    are 0, and the sum is reduced in proportion to their skewness where that is against the gambler. Both only make the
    wealth less.

    Source: de la Peña, A general class of exponential inequalities for martingales and ratios, The Annals of
    Probability 27 (1999), lemma 6.1; the mixture is that of Robbins, Statistical methods related to the law of the
    iterated logarithm, The Annals of Mathematical Statistics 41 (1970); that it holds for any distribution from a late
    first look on: Waudby-Smith, Arbour, Sinha, Kennedy and Ramdas, Time-uniform central limit theory and asymptotic
    confidence sequences, The Annals of Statistics 52 (2024); skewness as in Johnson, Modified t tests and confidence
    intervals for asymmetrical populations, Journal of the American Statistical Association 73 (1978).
    """

    def __init__(self, differences: Sequence[float]) -> None:
        np = arrays()
        given = finite(differences)
        # Squares of very small or very large differences would be 0 or infinite.
        self._unit = max(map(abs, given), default=0.0) or 1.0
        self._differences = np.asarray(given, float) / self._unit
        self._handicaps = _CAUTION * np.maximum(0.0, -np.asarray(asymmetries(self._differences.tolist()), float))
        self._differ = np.logical_or.accumulate(self._differences != 0)

    def log_wealth(self, value: float) -> Array:
        """Return the logarithm of the wealth after each difference: 0 before the first look."""
        np = arrays()
        if value == -math.inf:
            # From so far away all differences are alike.
            distances, handicaps = np.ones_like(self._differences), 0.0
        else:
            distances, handicaps = self._differences - value / self._unit, self._handicaps
        sums, squares = np.cumsum(distances) - handicaps, np.cumsum(distances**2)
        wealth: Array = np.zeros_like(squares)
        begun = np.flatnonzero(squares[FIRST_LOOK - 1 :] > 0) + FIRST_LOOK - 1
        if len(begun):
            prior, looks = _PRIOR * squares[begun[0]], begun[self._differ[begun]]
            spread = squares[looks] + prior
            scores = sums[looks] / np.sqrt(spread)
            odds = math.log(2) + log_normal_probability()(scores) + scores**2 / 2
            wealth[looks] = odds - np.log(spread / prior) / 2
        return wealth


class YesNoBets:
    """Bets on differences of yes and no: -1, 0 or 1; or on others that can't be below -1.

    A share c multiplies the wealth by 1 + c ((d + 1) / (value + 1) - 1), which is 1 on average if the mean of d is the
    value, whatever else its distribution is, and less if it is below. At the value 0, only pairs that differ count.

    Source: Waudby-Smith and Ramdas, Estimating means of bounded random variables by betting, Journal of the Royal
    Statistical Society B 86 (2024), the capital process with constant bets, of which we take a mixture.

    Raises:
        ValueError: A difference is below -1.
    """

    def __init__(self, differences: Sequence[float]) -> None:
        for number, difference in enumerate(differences):
            if not difference >= -1:
                raise ValueError(f"difference {number} is {difference}; expected -1 or more, of values that are 0 or 1")
        self._differences = arrays().asarray(differences, float)

    def log_wealth(self, value: float) -> Array:
        """Return the logarithm of the wealth after each difference; the value is above -1."""
        np = arrays()
        return _mixed(np.log1p(np.outer((self._differences + 1) / (value + 1) - 1, _SHARES)))


def _mixed(steps: Array) -> Array:
    """Return the logarithm of the mean wealth of all stakes, a column each, after each row."""
    np = arrays()
    total = np.logaddexp.reduce(np.cumsum(steps, axis=0), axis=1)
    return cast("Array", total - math.log(steps.shape[1]))
