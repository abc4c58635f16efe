"""Stopping rules: replicate until an interval is narrow, and stays narrow for some more runs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from hmrsim.experiments.statistics.intervals import CONFIDENCE, checked_share, proportion_interval
from hmrsim.experiments.statistics.summaries import distributions, prefixes

MEAN: Final = "mean"
"""A rule of a mean: its interval has to be narrow enough."""
PROPORTION: Final = "proportion"
"""A rule of a share of runs, such as of those that succeed."""

_SHORT: Final = 100
"""Replications up to which the look-ahead is *look_ahead*; from there on it grows with their number."""


@dataclass(frozen=True)
class StoppingRule:
    """A rule for when to stop replicating.

    Attributes:
        error: The half-width of the interval that is small enough: relative to the mean, or absolute for a proportion,
            such as 0.05 for five percentage points.
        of: ``mean``, or ``proportion`` of values that are 0 or 1.
        confidence: The confidence of the interval.
        minimum: The minimum number of replications; at least 3, since the spread of fewer is hardly known.
        maximum: The maximum number of replications; None for no maximum.
        look_ahead: The number of further replications for which the interval has to stay narrow (kLimit), since a
            narrow interval is often chance; from 100 replications on, a percentage. 0 for none.
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

    They are if after some number n of them, *minimum* at least, the interval was narrow and stayed so up to n + f,
    where f is *look_ahead* for n up to 100 and *look_ahead* n / 100 from there on; and if there are *maximum*. More
    values never make it too few.

    The interval of a number of runs that was chosen by looking at it covers the true value a little less often than
    it says.

    Source: Hoad, Robinson and Davies, Automated selection of the number of replications for a discrete-event
    simulation, Journal of the Operational Research Society 61 (2010), the algorithm with its look-ahead, kLimit = 5;
    Law, Simulation Modeling and Analysis, 5th edition (2015), section 9.4.1 (the sequential procedure).

    Raises:
        ValueError: A value is not finite, or not 0 or 1 where the rule is of a proportion.
    """
    if rule.maximum is not None and len(values) >= rule.maximum:
        return True
    since = None
    for n, error in enumerate(_errors(values, rule), 1):
        if n < rule.minimum or error > rule.error:
            since = None
            continue
        since = n if since is None else since
        if n >= since + _look_ahead(since, rule):
            return True
    return False


def replications_needed(values: Sequence[float], rule: StoppingRule) -> int | None:
    """Return the total number of replications that will be enough, if further ones resemble those so far.

    An estimate for progress displays: the least n for which t(n - 1) s / √n is small enough, with the mean and the
    standard deviation s so far, plus the look-ahead; for proportions with Wilson's interval. None if there is no
    estimate: there are fewer than two values, or the mean is 0 while values differ, and the rule has no maximum.

    Source: Law, Simulation Modeling and Analysis, 5th edition (2015), section 9.4.1, the approximate n*; the error is
    relative to the sample mean, as Hoad, Robinson and Davies (2010) have it.

    Raises:
        ValueError: As for `enough`.
    """
    done = len(values)
    if enough(values, rule):
        return done
    found = _least(values, rule)
    if found is None:
        return rule.maximum
    needed = max(done + 1, found + _look_ahead(found, rule))
    return needed if rule.maximum is None else min(needed, rule.maximum)


def _errors(values: Sequence[float], rule: StoppingRule) -> list[float]:
    """Return the half-widths after each value, relative for means; infinite where there is no bound."""
    means, deviations = prefixes(values)
    if rule.of == PROPORTION:
        counts = _successes(values)
        return [
            proportion_interval(count, n, confidence=rule.confidence).half_width for n, count in enumerate(counts, 1)
        ]
    n = range(1, len(values))
    quantiles = [math.inf, *map(float, distributions().t.isf((1 - rule.confidence) / 2, list(n)))] if values else []
    return [
        _relative(quantile, deviation, mean, number)
        for number, (quantile, deviation, mean) in enumerate(zip(quantiles, deviations, means, strict=True), 1)
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


def _relative(quantile: float, deviation: float, mean: float, n: int) -> float:
    if n == 1:
        return math.inf
    half = quantile * deviation / math.sqrt(n)
    if half == 0:
        return 0.0
    return half / abs(mean) if mean else math.inf


def _look_ahead(n: int, rule: StoppingRule) -> int:
    return rule.look_ahead if n <= _SHORT else rule.look_ahead * n // _SHORT


def _least(values: Sequence[float], rule: StoppingRule) -> int | None:
    """Return the smallest number of replications whose interval would be narrow."""
    if len(values) < 2:  # noqa: PLR2004
        return None
    means, deviations = prefixes(values)
    mean, deviation, share = means[-1], deviations[-1], sum(values) / len(values)

    def error(n: int) -> float:
        if rule.of == PROPORTION:
            return proportion_interval(round(share * n), n, confidence=rule.confidence).half_width
        return _relative(float(distributions().t.isf((1 - rule.confidence) / 2, n - 1)), deviation, mean, n)

    if math.isinf(error(2)):
        return None
    high = rule.minimum
    while error(high) > rule.error:
        high *= 2
    low = rule.minimum
    while low < high:
        middle = (low + high) // 2
        low, high = (low, middle) if error(middle) <= rule.error else (middle + 1, high)
    return high
