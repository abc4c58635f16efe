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

from hmrsim.experiments.statistics.libraries import arrays
from hmrsim.experiments.statistics.moments import finite, prefixes

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

Array: TypeAlias = "NDArray[np.float64]"

_STAKES: Final = tuple(2.0**power for power in range(-5, 2))
"""For real numbers: differences from the value, in standard deviations, that are found soonest."""

_SHARES: Final = (1 / 32, 1 / 16, 1 / 8, 1 / 4, 1 / 2, 3 / 4, 15 / 16)
"""For yes or no: shares of the wealth that the least difference would lose."""


class Bets(Protocol):
    """Bets on some differences in their order."""

    def log_wealth(self, value: float) -> Array:
        """Return the logarithm of the wealth after each difference, of betting that they lie above the value.

        It falls as the value rises.
        """


class SymmetricBets:
    """Bets on differences of real numbers.

    A stake of κ multiplies the wealth by 1 + tanh(κ (d - value) / s), where s is the standard deviation of the
    differences before this one. If d is distributed symmetrically about the value, whatever its tails, and whatever
    came before, the factor is 1 on average. For normal differences whose mean is κ s above the value it is the
    likelihood ratio, given how far d is from the value. No bet is made before s is known: on the first difference, and
    while all were 0; while all were equal, s is their size.

    Two controllers that do the same have symmetrical differences, as each could as well have been the other. Of other
    differences, the mean is tested as precisely as Student's t does it: the error vanishes with their number.

    Source: symmetry and self-normalisation as in de la Peña, A general class of exponential inequalities for
    martingales and ratios, The Annals of Probability 27 (1999), lemma 6.1, whose factor exp(x - x²/2) is never more
    than ours, exp(x) / cosh(x) = 1 + tanh(x); mixtures of predictable bets as in Waudby-Smith and Ramdas, Estimating
    means of bounded random variables by betting, Journal of the Royal Statistical Society B 86 (2024).
    """

    def __init__(self, differences: Sequence[float]) -> None:
        np = arrays()
        given = finite(differences)
        means, deviations = prefixes(given)
        before = [0.0, *(deviation or abs(mean) for mean, deviation in zip(means, deviations, strict=True))][:-1]
        self._differences = np.asarray(given, float)
        self._is_bet = np.asarray(before[: len(given)], float) > 0
        self._scales = np.where(self._is_bet, before[: len(given)], 1.0)

    def log_wealth(self, value: float) -> Array:
        """Return the logarithm of the wealth after each difference."""
        np = arrays()
        with np.errstate(over="ignore"):
            distances = (self._differences - value) / self._scales
            steps = math.log(2) - np.logaddexp(0, -2 * np.outer(distances, _STAKES))
        return _mixed(np.where(self._is_bet[:, None], steps, 0.0))


class YesNoBets:
    """Bets on differences of yes and no: -1, 0 or 1.

    A share c multiplies the wealth by 1 + c ((d + 1) / (value + 1) - 1), which is 1 on average if the mean of d is the
    value, whatever else its distribution is, and less if it is below. At the value 0, only pairs that differ count.

    Source: Waudby-Smith and Ramdas, Estimating means of bounded random variables by betting, Journal of the Royal
    Statistical Society B 86 (2024), the capital process with constant bets, of which we take a mixture.

    Raises:
        ValueError: A difference is none of these.
    """

    def __init__(self, differences: Sequence[float]) -> None:
        for number, difference in enumerate(differences):
            if difference not in (-1, 0, 1):
                raise ValueError(f"difference {number} is {difference}; expected -1, 0 or 1, of values that are 0 or 1")
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
