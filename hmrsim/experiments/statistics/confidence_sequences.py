"""Confidence sequences: intervals that may be looked at after each pair, and that only become narrower."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Final, Protocol, TypeAlias, cast

from hmrsim.experiments.statistics.intervals import CONFIDENCE, Interval, checked_share
from hmrsim.experiments.statistics.summaries import (
    arrays,
    asymmetries,
    finite,
    log_normal_probability,
    moments,
    root_finder,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_LEAST: Final = -1.0
"""The mean difference of yes and no can't be less."""

_DOUBLINGS: Final = 60
_PRECISION: Final = 1e-12


def confidence_sequence(
    differences: Sequence[float], *, yes_no: bool = False, confidence: float = CONFIDENCE
) -> Interval:
    """Return the mean of paired differences, with bounds that hold at all times together.

    With the given confidence, the bounds after each number of pairs all contain the true mean, so you can look at any
    time and stop at any time. The bounds enclose the values that no look so far has excluded: the running intersection.
    A value is excluded once a gambler who bets that the differences lie above it, or below it, has turned 1 into
    2 / alpha.

    - Of yes and no (differences -1, 0, 1) this holds for any distribution.
    - Of real numbers it holds exactly if the differences are symmetrical about their mean, whatever their tails, as
      those of equal controllers are; else nearly so, the less the more skewed they are.

    Real numbers have no bounds before 30 pairs, nor while all differences are 0: how large others are is not known
    then.

    A bound is widened to the present mean if that is beyond it. If the intersection is empty, because the true mean has
    changed, the bounds are those of the last look alone. Neither reduces the confidence: if the bounds after each
    number of pairs contain the true mean, then those of the last look do, and every set that contains the intersection.

    Source: Darling and Robbins, Confidence sequences for mean, variance, and median, Proceedings of the National
    Academy of Sciences 58 (1967); `RealBets` and `YesNoBets` say whose bets they are.

    Args:
        differences: The differences, in the order of their seeds.
        yes_no: Whether they are differences of yes and no.
        confidence: The confidence of the bounds.

    Raises:
        ValueError: A difference is not finite, or not -1, 0 or 1 for yes and no.
    """
    alpha = 1 - checked_share(confidence, "confidence")
    given = finite(differences)
    if yes_no:
        for number, difference in enumerate(given):
            if difference not in (-1, 0, 1):
                raise ValueError(
                    f"difference {number} is {difference:g}; expected -1, 0 or 1, of values that are 0 or 1"
                )
    low, high = (_bound(given, way, alpha, yes_no=yes_no) for way in (1, -1))
    if low is not None and high is not None and low > high:
        low, high = (_bound(given, way, alpha, yes_no=yes_no, last=True) for way in (1, -1))
    mean = moments(given).mean
    if mean is not None:
        low, high = None if low is None else min(low, mean), None if high is None else max(high, mean)
    return Interval(mean, low, high, len(given), confidence)


def first_above(differences: Sequence[float], value: float, alpha: float, *, yes_no: bool) -> int | None:
    """Return the number of differences after which their mean is known to be above a value; None if it is not known.

    If it is not above, the probability of ever claiming so is at most alpha / 2: the other half is for the mean being
    below. This is when the lower bound of `confidence_sequence` is first above the value.
    """
    if not differences:
        return None
    known = _bets(differences, yes_no=yes_no).log_wealth(value) >= _threshold(alpha)
    return int(known.argmax()) + 1 if known.any() else None


def _bets(differences: Sequence[float], *, yes_no: bool) -> Bets:
    return YesNoBets(differences) if yes_no else RealBets(differences)


def _threshold(alpha: float) -> float:
    return math.log(2 / alpha)


def _bound(differences: Sequence[float], way: int, alpha: float, *, yes_no: bool, last: bool = False) -> float | None:
    """Return the highest value above which the mean is known to be, or for a *way* of -1 the lowest below which it is.

    It is known by any look, or, if *last*, by the last one.
    """
    least = _LEAST if yes_no else None
    given = [way * difference for difference in differences]
    bets, threshold = _bets(given, yes_no=yes_no), _threshold(alpha)

    def surplus(value: float) -> float:
        wealth = bets.log_wealth(value)
        return float(wealth[-1] if last else wealth.max()) - threshold

    excluded = _excluded(surplus, given, least) if given else None
    if excluded is None:
        return None if least is None else way * least
    # Bets that differences lie above the largest one never gain.
    highest = max(given)
    precision = _PRECISION * max(abs(excluded), abs(highest))
    return way * float(root_finder()(surplus, excluded, highest, xtol=precision))


def _excluded(surplus: Callable[[float], float], differences: Sequence[float], least: float | None) -> float | None:
    """Return some value above which the mean is known to be; None if there is none."""
    lowest = -math.inf if least is None else least + _PRECISION
    if surplus(lowest) < 0:
        return None
    if least is not None:
        return lowest
    bottom = min(differences)
    step = (max(differences) - bottom) or abs(bottom) or 1.0
    for _ in range(_DOUBLINGS):
        if surplus(bottom - step) >= 0:
            return bottom - step
        step *= 2
    return None


Array: TypeAlias = "NDArray[np.float64]"

FIRST_LOOK: Final = 30
"""The number of differences of real numbers before the first bounds."""

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
    large ones that make up for it have not come yet. So no wealth is computed before the 30th difference, nor while all
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
