"""What is in a column: how many values, their mean, spread and quantiles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from hmrsim.experiments.statistics.moments import finite, moments

_SHARES: Final = (0.05, 0.25, 0.5, 0.75, 0.95)


@dataclass(frozen=True)
class Summary:
    """A column in short; what has no value is None.

    Attributes:
        count: Of values that are there.
        missing: How many are None.
        mean: Of those that are there, as all that follows.
        stddev: That of a sample, over count - 1; None for fewer than two values.
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
    """Return what is in a column, in which None is a value that is missing.

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
