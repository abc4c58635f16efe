"""Confidence sequences: intervals that may be looked at after each pair, and that only become narrower."""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable, Sequence
from typing import Final

from hmrsim.experiments.statistics.intervals import CONFIDENCE, Interval, checked_share
from hmrsim.experiments.statistics.libraries import root_finder
from hmrsim.experiments.statistics.moments import finite, moments
from hmrsim.experiments.statistics.wealth import Bets, SymmetricBets, YesNoBets

_LEAST: Final = -1.0
"""The mean difference of yes and no can't be less."""

_DOUBLINGS: Final = 1000
_PRECISION: Final = 1e-12


def confidence_sequence(
    differences: Sequence[float], *, yes_no: bool = False, confidence: float = CONFIDENCE
) -> Interval:
    """Return the mean of paired differences, with bounds that hold at all times together.

    With the confidence, the bounds after each number of pairs contain the true mean, so that one may look whenever
    one likes and stop when one likes. They are those that no look so far has excluded: the running intersection. A
    value is excluded once a gambler who bets that the differences lie above it, or one who bets that they lie below,
    has made 2 / alpha out of 1.

    - Of yes and no (differences -1, 0, 1) this holds for any distribution.
    - Of real numbers it holds exactly if the differences are symmetrical about their mean, whatever their tails, as
      those of equal controllers are; else nearly so, the more the larger their number.

    Real numbers have no bounds before eight pairs or so, as six signs could all be equal by chance, nor while all
    differences are 0: how large others are is not known then.

    Should the true mean change on the way, so that nothing is left of the intersection, the last bounds are kept; they
    are widened to the present mean where that is beyond them.

    Source: Darling and Robbins, Confidence sequences for mean, variance, and median, Proceedings of the National
    Academy of Sciences 58 (1967); `SymmetricBets` and `YesNoBets` say whose bets they are.

    Args:
        differences: In the order of their seeds.
        yes_no: Whether they are those of yes and no.
        confidence: Of the bounds.

    Raises:
        ValueError: A difference is not finite, or not -1, 0 or 1 for yes and no.
    """
    alpha = 1 - checked_share(confidence, "confidence")
    given = finite(differences)
    low, high = _bounds(given, alpha, yes_no=yes_no)
    if _are_crossed((low, high)):
        most = bisect.bisect_left(
            range(len(given)), True, key=lambda n: _are_crossed(_bounds(given[:n], alpha, yes_no=yes_no))
        )
        low, high = _bounds(given[: most - 1], alpha, yes_no=yes_no)
    mean = moments(given).mean
    if mean is not None:
        # Where the mean has moved, bounds that earlier looks gave do not hold for what it is now.
        low, high = None if low is None else min(low, mean), None if high is None else max(high, mean)
    return Interval(mean, low, high, len(given), confidence)


def first_above(differences: Sequence[float], value: float, alpha: float, *, yes_no: bool) -> int | None:
    """Return after how many differences it is known that their mean is above a value; None if it is not known.

    If it is not above, that is said at any time with probability alpha / 2 at most: the other half is for the mean
    being below. It is when the lower bound of `confidence_sequence` first is above the value.
    """
    if not differences:
        return None
    known = _bets(differences, yes_no=yes_no).log_wealth(value) >= _threshold(alpha)
    return int(known.argmax()) + 1 if known.any() else None


def _bets(differences: Sequence[float], *, yes_no: bool) -> Bets:
    return YesNoBets(differences) if yes_no else SymmetricBets(differences)


def _bounds(differences: Sequence[float], alpha: float, *, yes_no: bool) -> tuple[float | None, float | None]:
    """Return the highest value above which the mean is known to be, and the lowest below which it is."""
    low = _lower_bound(differences, alpha, yes_no=yes_no)
    below = _lower_bound([-difference for difference in differences], alpha, yes_no=yes_no)
    return low, None if below is None else -below


def _are_crossed(bounds: tuple[float | None, float | None]) -> bool:
    low, high = bounds
    return low is not None and high is not None and low > high


def _threshold(alpha: float) -> float:
    return math.log(2 / alpha)


def _lower_bound(differences: Sequence[float], alpha: float, *, yes_no: bool) -> float | None:
    """Return the highest value above which the mean is known to be."""
    least = _LEAST if yes_no else None
    if not differences:
        return least
    bets, threshold = _bets(differences, yes_no=yes_no), _threshold(alpha)

    def surplus(value: float) -> float:
        return float(bets.log_wealth(value).max()) - threshold

    excluded = _excluded(surplus, differences, least)
    if excluded is None:
        return least
    # Nobody makes money by betting that differences lie above the largest one.
    highest = max(differences)
    precision = _PRECISION * max(abs(excluded), abs(highest))
    return float(root_finder()(surplus, excluded, highest, xtol=precision))


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
