"""Confidence intervals for a fixed number of runs, and rules that stop replication once they are narrow."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from statistics import NormalDist
from typing import Final

from hmrsim.experiments.statistics.summaries import distributions, finite, moments, prefixes, quantile

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


MEAN: Final = "mean"
"""A rule on the mean of the values."""
PROPORTION: Final = "proportion"
"""A rule on a share of runs, such as the successful ones."""

_CONSTANT_UP_TO: Final = 100
"""The number of replications from which the look-ahead grows in proportion to it."""


@dataclass(frozen=True)
class StoppingRule:
    """A rule for when to stop replicating.

    Attributes:
        error: The maximum half-width of the interval: relative to the mean, or absolute for a proportion, such as
            0.05 for five percentage points.
        of: ``mean``, or ``proportion`` of values that are 0 or 1.
        confidence: The confidence of the interval.
        minimum: The minimum number of replications; at least 3, since fewer hardly show the spread.
        maximum: The maximum number of replications; None for no maximum.
        look_ahead: The number of further replications for which the interval has to stay narrow (kLimit), since it
            is often narrow by chance; from 100 replications on, a percentage of them. 0 for none.
    """

    error: float
    of: str = MEAN
    confidence: float = CONFIDENCE
    minimum: int = 3
    maximum: int | None = None
    look_ahead: int = 5

    def __post_init__(self) -> None:
        """Raise ValueError if a value is out of range."""
        checked_share(self.confidence, "confidence")
        if not self.error > 0:
            raise ValueError(f"error must be positive, got {self.error}")
        if self.of not in (MEAN, PROPORTION):
            raise ValueError(f"no rule for {self.of!r}; there are {MEAN}, {PROPORTION}")
        if self.minimum < 3:  # noqa: PLR2004
            raise ValueError(f"minimum must be 3 or more, got {self.minimum}")
        if self.maximum is not None and self.maximum < self.minimum:
            raise ValueError(f"maximum must be {self.minimum} or more, as the minimum, got {self.maximum}")
        if self.look_ahead < 0:
            raise ValueError(f"look_ahead must be 0 or more, got {self.look_ahead}")


def enough(values: Sequence[float], rule: StoppingRule) -> bool:
    """Return whether the replications done so far are enough.

    They are enough if the interval was narrow after n of them, where n is *minimum* or more, and stayed narrow up to
    n + f, where f is *look_ahead* for n up to 100 and *look_ahead* n / 100 above. *maximum* replications are always
    enough. Once the replications are enough, further ones don't change that.

    Since the number of runs depends on the interval, the final interval covers the true value a little less often than
    its confidence.

    Source: Hoad, Robinson and Davies, Automated selection of the number of replications for a discrete-event
    simulation, Journal of the Operational Research Society 61 (2010), the algorithm with its look-ahead, kLimit = 5;
    Law, Simulation Modeling and Analysis, 5th edition (2015), section 9.4.1 (the sequential procedure).

    Raises:
        ValueError: A value is not finite, or not 0 or 1 for a proportion.
    """
    if rule.maximum is not None and len(values) >= rule.maximum:
        return True
    since = None
    for n, half_width in enumerate(_half_widths(values, rule), 1):
        if n < rule.minimum or half_width > rule.error:
            since = None
            continue
        since = n if since is None else since
        if n >= since + _look_ahead(since, rule):
            return True
    return False


def replications_needed(values: Sequence[float], rule: StoppingRule) -> int | None:
    """Return an estimate of the total number of replications that will be enough, for progress displays.

    It is the least n for which t(n - 1) s / √n is small enough, with the mean and the standard deviation s so far, plus
    the look-ahead; for proportions, with Wilson's interval. None if the rule has no maximum and there is no estimate,
    because there are fewer than two values, or the mean is 0 while values differ.

    Source: Law, Simulation Modeling and Analysis, 5th edition (2015), section 9.4.1, the approximate n*; the error is
    relative to the sample mean, as Hoad, Robinson and Davies (2010) have it.

    Raises:
        ValueError: As for `enough`.
    """
    done = len(values)
    if enough(values, rule):
        return done
    narrow_from = _narrow_from(values, rule)
    if narrow_from is None:
        return rule.maximum
    needed = max(done + 1, narrow_from + _look_ahead(narrow_from, rule))
    return needed if rule.maximum is None else min(needed, rule.maximum)


def _half_widths(values: Sequence[float], rule: StoppingRule) -> list[float]:
    """Return the half-width of the interval after each value, relative for means; infinite if it is unbounded."""
    means, deviations = prefixes(values)
    if rule.of == PROPORTION:
        counts = _successes(values)
        return [
            proportion_interval(count, n, confidence=rule.confidence).half_width for n, count in enumerate(counts, 1)
        ]
    freedoms = list(range(1, len(values)))
    quantiles = [math.inf, *map(float, distributions().t.isf((1 - rule.confidence) / 2, freedoms))] if values else []
    return [
        _relative_half_width(quantile, deviation, mean, n)
        for n, (quantile, deviation, mean) in enumerate(zip(quantiles, deviations, means, strict=True), 1)
    ]


def _successes(values: Sequence[float]) -> list[int]:
    """Return the number of ones among the first value, the first two, and so on."""
    count, counts = 0, []
    for number, value in enumerate(values):
        if value not in (0, 1):
            raise ValueError(f"value {number} is {value}; expected 0 or 1 for a proportion")
        count += value == 1
        counts.append(count)
    return counts


def _relative_half_width(quantile: float, deviation: float, mean: float, n: int) -> float:
    if n == 1:
        return math.inf
    half_width = quantile * deviation / math.sqrt(n)
    if half_width == 0:
        return 0.0
    return half_width / abs(mean) if mean else math.inf


def _look_ahead(n: int, rule: StoppingRule) -> int:
    return rule.look_ahead if n <= _CONSTANT_UP_TO else rule.look_ahead * n // _CONSTANT_UP_TO


def _narrow_from(values: Sequence[float], rule: StoppingRule) -> int | None:
    """Return the estimated number of replications from which the interval is narrow; None if there is no estimate."""
    if len(values) < 2:  # noqa: PLR2004
        return None
    means, deviations = prefixes(values)
    mean, deviation, share = means[-1], deviations[-1], sum(values) / len(values)

    def half_width(n: int) -> float:
        if rule.of == PROPORTION:
            return proportion_interval(round(share * n), n, confidence=rule.confidence).half_width
        quantile = float(distributions().t.isf((1 - rule.confidence) / 2, n - 1))
        return _relative_half_width(quantile, deviation, mean, n)

    if math.isinf(half_width(2)):
        return None
    high = rule.minimum
    while half_width(high) > rule.error:
        high *= 2
    low = rule.minimum
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if half_width(middle) <= rule.error else (middle + 1, high)
    return high
