"""Summaries of a column of values: count, mean, spread and quantiles."""

from __future__ import annotations

import importlib
import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

from hmrsim.errors import MissingExtra

if TYPE_CHECKING:
    from types import ModuleType

_SHARES: Final = (0.05, 0.25, 0.5, 0.75, 0.95)


@dataclass(frozen=True)
class Summary:
    """The summary of a column; missing statistics are None.

    Attributes:
        count: The number of values that are not missing.
        missing: The number of missing values.
        stddev: The standard deviation of a sample, over count - 1; None for fewer than two values.
        least: The minimum.
        most: The maximum.
        quantiles: By share; empty without a value.
    """

    count: int
    missing: int
    mean: float | None
    stddev: float | None
    least: float | None
    most: float | None
    quantiles: Mapping[float, float]


def summary(column: Sequence[float | None], shares: Sequence[float] = _SHARES) -> Summary:
    """Return the summary of a column, in which None is a missing value.

    Raises:
        ValueError: A value is not finite, or a share is not within 0 and 1.
    """
    ordered = sorted(finite(value for value in column if value is not None))
    found = moments(ordered)
    return Summary(
        count=found.n,
        missing=len(column) - found.n,
        mean=found.mean,
        stddev=found.stddev,
        least=ordered[0] if ordered else None,
        most=ordered[-1] if ordered else None,
        quantiles={share: quantile(ordered, share) for share in shares} if ordered else {},
    )


def quantile(ordered: Sequence[float], share: float) -> float:
    """Return a quantile of values in ascending order, with straight lines between them.

    Source: Hyndman and Fan, Sample quantiles in statistical packages, The American Statistician 50 (1996), definition
    7, which is the default of numpy, R and spreadsheets.

    Raises:
        ValueError: There is no value, or the share is not within 0 and 1.
    """
    if not ordered:
        raise ValueError("no values; expected one at least")
    if not 0 <= share <= 1:
        raise ValueError(f"share must be within 0 and 1, got {share}")
    place = (len(ordered) - 1) * share
    before = int(place)
    after = min(before + 1, len(ordered) - 1)
    return ordered[before] + (ordered[after] - ordered[before]) * (place - before)


_MOST: Final = 1e100


@dataclass(frozen=True)
class Moments:
    """Count, mean and standard deviation of some values.

    Attributes:
        mean: The mean; None without a value.
        stddev: The standard deviation of a sample, over n - 1; None for fewer than two values; exactly 0 if all are
            equal.
    """

    n: int
    mean: float | None
    stddev: float | None


def moments(values: Sequence[float]) -> Moments:
    """Return the mean and the standard deviation.

    Raises:
        ValueError: A value is not finite.
    """
    given = finite(values)
    n = len(given)
    if not given:
        return Moments(0, None, None)
    if min(given) == max(given):
        return Moments(n, given[0], 0.0 if n > 1 else None)
    mean = math.fsum(value / n for value in given)
    return Moments(n, mean, math.hypot(*(value - mean for value in given)) / math.sqrt(n - 1))


def prefixes(values: Sequence[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the means and the standard deviations of the first value, the first two, and so on.

    The standard deviation of one value is 0 here, as is that of equal ones. Source: Welford, Note on a method for
    calculating corrected sums of squares and products, Technometrics 4 (1962).

    Raises:
        ValueError: A value is not finite.
    """
    means, deviations = [], []
    mean = squares = 0.0
    for number, value in enumerate(finite(values), 1):
        step = value - mean
        mean += step / number
        squares += step * (value - mean)
        means.append(mean)
        deviations.append(math.sqrt(squares / (number - 1)) if number > 1 else 0.0)
    return tuple(means), tuple(deviations)


def asymmetries(values: Sequence[float]) -> tuple[float, ...]:
    """Return the skewness times the standard deviation of the first value, the first two, and so on.

    It is the third central moment over the second one; 0 of values that are all equal. Source: Pébay, Formulas for
    robust, one-pass parallel computation of covariances and arbitrary-order statistical moments, Sandia National
    Laboratories (2008), equations 1.1 to 1.3 for one value more.

    Raises:
        ValueError: A value is not finite.
    """
    ratios = []
    mean = squares = cubes = 0.0
    for number, value in enumerate(finite(values), 1):
        step = value - mean
        part = step / number
        cubes += step * part * (number - 1) * part * (number - 2) - 3 * part * squares
        squares += step * part * (number - 1)
        mean += part
        ratios.append(cubes / squares if squares > 0 else 0.0)
    return tuple(ratios)


def finite(values: Iterable[float]) -> tuple[float, ...]:
    """Return values as floats.

    Raises:
        ValueError: One is not finite, or so large that its square might not be.
    """
    given = tuple(map(float, values))
    for number, value in enumerate(given):
        if not abs(value) <= _MOST:
            raise ValueError(f"value {number} is {value}; expected numbers up to {_MOST:g} in size")
    return given


def pairs(a: Sequence[float], b: Sequence[float]) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return the values of two treatments under the same seeds, as floats.

    Raises:
        ValueError: There are not as many of one as of the other, or one is not finite.
    """
    if len(a) != len(b):
        raise ValueError(f"{len(a)} values of A and {len(b)} of B; expected one of each for each seed")
    return finite(a), finite(b)


def arrays() -> ModuleType:
    """Return ``numpy``; raise MissingExtra if it is not installed."""
    return _extra("numpy")


def distributions() -> Any:
    """Return ``scipy.stats``; raise MissingExtra if it is not installed."""
    return _extra("scipy.stats")


def root_finder() -> Any:
    """Return ``scipy.optimize.brentq``; raise MissingExtra if it is not installed."""
    return _extra("scipy.optimize").brentq


def log_normal_probability() -> Any:
    """Return ``scipy.special.log_ndtr``, the log of the normal distribution; raise MissingExtra if not installed."""
    return _extra("scipy.special").log_ndtr


def _extra(name: str) -> ModuleType:
    try:
        return importlib.import_module(name)
    except ImportError:
        raise MissingExtra("the statistics of experiments need scipy; pip install 'hmrsim[experiments]'") from None
