"""Confidence sequences: intervals that may be looked at after each pair, and that only become narrower."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Final

from hmrsim.experiments.statistics.intervals import CONFIDENCE, Interval, checked_share
from hmrsim.experiments.statistics.libraries import root_finder
from hmrsim.experiments.statistics.moments import finite, moments
from hmrsim.experiments.statistics.wealth import Bets, RealBets, YesNoBets

_LEAST: Final = -1.0
"""The mean difference of yes and no can't be less."""

_DOUBLINGS: Final = 60
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
      those of equal controllers are; else nearly so, the less the more skewed they are.

    Real numbers have no bounds before 30 pairs, nor while all differences are 0: how large others are is not known
    then.

    Where the present mean is beyond a bound, that is widened to it. Should nothing be left of the intersection, as the
    true mean has changed on the way, the bounds are those of the last look alone. Neither costs any confidence: where
    the bounds after each number of pairs contain the true mean, so do those of the last look, and so does whatever
    contains the intersection.

    Source: Darling and Robbins, Confidence sequences for mean, variance, and median, Proceedings of the National
    Academy of Sciences 58 (1967); `RealBets` and `YesNoBets` say whose bets they are.

    Args:
        differences: In the order of their seeds.
        yes_no: Whether they are those of yes and no.
        confidence: Of the bounds.

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
    """Return after how many differences it is known that their mean is above a value; None if it is not known.

    If it is not above, that is said at any time with probability alpha / 2 at most: the other half is for the mean
    being below. It is when the lower bound of `confidence_sequence` first is above the value.
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
    # Nobody makes money by betting that differences lie above the largest one.
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
