"""Mean and standard deviation of numbers that were checked."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Final

_MOST: Final = 1e100


@dataclass(frozen=True)
class Moments:
    """Count, mean and standard deviation of some values.

    Attributes:
        n: How many there are.
        mean: None without a value.
        stddev: That of a sample, over n - 1; None for fewer than two values; exactly 0 if all are equal.
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
