"""Confidence intervals of a mean, a proportion and a quantile, for a number of runs that was fixed beforehand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Final

from hmrsim.experiments.statistics.summaries import distributions, finite, moments, quantile

CONFIDENCE: Final = 0.95
"""The default confidence."""


@dataclass(frozen=True)
class Interval:
    """An estimate and the bounds of the values that are compatible with the data.

    Attributes:
        estimate: None without any data.
        low: The lower bound; None if the data exclude no value, however low.
        high: The upper bound; None if the data exclude no value, however high.
        n: The number of values.
        confidence: The share of such intervals that contain the true value, such as 0.95.
    """

    estimate: float | None
    low: float | None
    high: float | None
    n: int
    confidence: float

    @property
    def half_width(self) -> float:
        """Half of the distance of the bounds; infinite if one is missing."""
        return math.inf if self.low is None or self.high is None else (self.high - self.low) / 2


def mean_interval(values: Sequence[float], *, confidence: float = CONFIDENCE, n: int | None = None) -> Interval:
    """Return the mean with Student's t interval, mean ± t(n - 1) s / √n.

    It is exact for normal values, and nearly so for others if there are enough of them, the more the more skewed they
    are. One value has no bounds. Equal values have bounds that are equal to them, which says nothing about values
    that are rare.

    Source: Student, The probable error of a mean, Biometrika 6 (1908); Law, Simulation Modeling and Analysis, 5th
    edition (2015), section 4.5.

    Args:
        values: The values.
        confidence: The confidence of the interval.
        n: The effective number of values, if some repeat others; None for all.

    Raises:
        ValueError: A value is not finite, or the confidence is not between 0 and 1.
    """
    alpha = 1 - checked_share(confidence, "confidence")
    found = moments(values)
    count = found.n if n is None else n
    if found.mean is None or found.stddev is None or count < 2:  # noqa: PLR2004 - one value has no spread
        return Interval(found.mean, None, None, count, confidence)
    # The spread of n values that occur equally often.
    spread = found.stddev if count == found.n else found.stddev * math.sqrt((1 - 1 / found.n) / (1 - 1 / count))
    half = float(distributions().t.isf(alpha / 2, count - 1)) * spread / math.sqrt(count)
    return Interval(found.mean, found.mean - half, found.mean + half, count, confidence)


def proportion_interval(successes: float, n: int, *, confidence: float = CONFIDENCE) -> Interval:
    """Return a share with Wilson's score interval, without a correction for continuity.

    Its bounds are within 0 and 1, also for no success and for nothing but successes. Its coverage is near the
    confidence on average, and may be a little below it for single shares. Of no trial nothing is known: 0 to 1.

    Source: Wilson, Probable inference, the law of succession, and statistical inference, Journal of the American
    Statistical Association 22 (1927); Newcombe, Two-sided confidence intervals for the single proportion, Statistics
    in Medicine 17 (1998), method 3.

    Raises:
        ValueError: There are more successes than trials or fewer than none, or the confidence is not between 0 and 1.
    """
    checked_share(confidence, "confidence")
    if not 0 <= successes <= n:
        raise ValueError(f"{successes} successes of {n}; expected 0 to {n}")
    if n == 0:
        return Interval(None, 0.0, 1.0, 0, confidence)
    z = NormalDist().inv_cdf((1 + confidence) / 2)
    share, square = successes / n, z * z
    center = 2 * n * share + square
    half = z * math.sqrt(square + 4 * n * share * (1 - share))
    # Exactly 0 and 1, without the rounding errors of the formula.
    low = 0.0 if successes == 0 else (center - half) / (2 * (n + square))
    high = 1.0 if successes == n else (center + half) / (2 * (n + square))
    return Interval(share, low, high, n, confidence)


def quantile_interval(values: Sequence[float], share: float, *, confidence: float = CONFIDENCE) -> Interval:
    """Return a quantile with the interval between two of the ordered values.

    Whatever the distribution, the interval contains the true quantile with the confidence at least, with (1 -
    confidence) / 2 at most on either side: the number of values up to the quantile is binomial. A bound is None where
    there are too few values for any: the 95 % quantile has an upper bound from 72 values on.

    Source: Conover, Practical Nonparametric Statistics, 3rd edition (1999), section 3.2; Hahn and Meeker, Statistical
    Intervals (1991), section 5.2.

    Raises:
        ValueError: A value is not finite, or the share or the confidence is not between 0 and 1.
    """
    alpha = 1 - checked_share(confidence, "confidence")
    checked_share(share, "share")
    ordered = sorted(finite(values))
    n = len(ordered)
    if n == 0:
        return Interval(None, None, None, 0, confidence)
    below = distributions().binom(n, share)
    # Ranks from 1: the highest that the quantile is below, and the lowest that it is above, with alpha / 2 at most.
    lowest, highest = int(below.ppf(alpha / 2)), int(below.ppf(1 - alpha / 2)) + 1
    low = ordered[lowest - 1] if lowest > 0 else None
    high = ordered[highest - 1] if highest <= n else None
    return Interval(quantile(ordered, share), low, high, n, confidence)


def checked_share(share: float, name: str) -> float:
    """Return a number between 0 and 1; raise ValueError if it is not."""
    if not 0 < share < 1:
        raise ValueError(f"{name} must be between 0 and 1, got {share}")
    return share
