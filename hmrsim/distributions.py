"""The distributions that a world may have in place of seconds or factors.

Each value is the quantile of one random number. Two distributions sampled with the same number thus return values of
the same rank, so that runs that differ in a single parameter stay as similar as possible.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property
from statistics import NormalDist
from typing import Annotated, Any, Final, Self, TypeAlias

from pydantic import AfterValidator, BaseModel, ConfigDict, Discriminator, Field, RootModel, Tag, model_validator

from hmrsim.interfaces.quantities import SECONDS

_MAX: Final = 1e9
_STANDARD: Final = NormalDist()
_STEPS: Final = 1_000
"""The number of quantiles whose mean approximates the mean of a truncated distribution."""

Number = Annotated[float, Field(strict=True, ge=-_MAX, le=_MAX)]
NotNegative = Annotated[float, Field(strict=True, ge=0, le=_MAX)]
Positive = Annotated[float, Field(strict=True, gt=0, le=_MAX)]


class _Kind(BaseModel):
    """The parameters of a distribution."""

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)


class _Continuous(_Kind, ABC):
    """A continuous distribution, which may be truncated to bounds.

    Attributes:
        min: The minimum of the values, which are seconds or factors and never negative.
        max: The maximum of the values; None for no maximum.
    """

    min: NotNegative = 0.0
    max: Positive | None = None

    @abstractmethod
    def _cdf(self, value: float) -> float:
        """Return the probability of values up to this one, without bounds."""

    @abstractmethod
    def _quantile(self, u: float) -> float:
        """Return the value below which a fraction of all values lies, without bounds."""

    @property
    @abstractmethod
    def _mean(self) -> float:
        """The mean of the distribution before it is truncated."""

    @model_validator(mode="after")
    def _bounds(self) -> Self:
        if not self.min < self.greatest:
            raise ValueError(f"min {self.min:g} is not less than max {self.greatest:g}")
        if not self._span[0] < self._span[1]:
            raise ValueError(f"there are no values from {self.min:g} to {self.greatest:g}")
        return self

    @cached_property
    def _span(self) -> tuple[float, float]:
        """The range of probabilities whose quantiles are within the bounds."""
        return self._cdf(self.min), 1.0 if self.max is None else self._cdf(self.max)

    @property
    def least(self) -> float:
        """The minimum of the values."""
        return self.min

    @property
    def greatest(self) -> float:
        """The maximum of the values; infinite without a maximum."""
        return math.inf if self.max is None else self.max

    @cached_property
    def expected(self) -> float:
        """The mean of the values; for a truncated distribution, the mean of 1,000 quantiles."""
        if self._span == (0.0, 1.0):
            return self._mean
        return math.fsum(self.value((i + 0.5) / _STEPS) for i in range(_STEPS)) / _STEPS

    def value(self, u: float) -> float:
        """Return the value below which a fraction of all values lies."""
        low, high = self._span
        return min(max(self._quantile(low + u * (high - low)), self.min), self.greatest)


class Normal(_Continuous):
    """The normal distribution, truncated at 0, or at *min* and *max*.

    Attributes:
        mean: The mean before truncation.
        stddev: The standard deviation before truncation.
    """

    mean: Number
    stddev: Positive

    @property
    def _mean(self) -> float:
        return self.mean

    def _cdf(self, value: float) -> float:
        return _STANDARD.cdf((value - self.mean) / self.stddev)

    def _quantile(self, u: float) -> float:
        return self.mean + self.stddev * _STANDARD.inv_cdf(u)


class LogNormal(_Continuous):
    """The log-normal distribution, given by mean and standard deviation.

    Law, Simulation Modeling and Analysis, 5th edition, 6.2.2: the logarithms have the variance
    sigma² = ln(1 + (stddev/mean)²) and the mean ln(mean) - sigma²/2.

    Attributes:
        mean: The mean of the values, not of their logarithms.
        stddev: The standard deviation of the values, not of their logarithms.
    """

    mean: Positive
    stddev: Positive

    @cached_property
    def _sigma(self) -> float:
        return math.sqrt(math.log1p((self.stddev / self.mean) ** 2))

    @property
    def _mean(self) -> float:
        return self.mean

    def _cdf(self, value: float) -> float:
        if value <= 0.0:
            return 0.0
        return _STANDARD.cdf((math.log(value / self.mean) + self._sigma**2 / 2) / self._sigma)

    def _quantile(self, u: float) -> float:
        return self.mean * math.exp(self._sigma * _STANDARD.inv_cdf(u) - self._sigma**2 / 2)


class Exponential(_Continuous):
    """The exponential distribution: the time between independent events with a constant rate.

    Attributes:
        mean: The mean before truncation.
    """

    mean: Positive

    @property
    def _mean(self) -> float:
        return self.mean

    def _cdf(self, value: float) -> float:
        return -math.expm1(-value / self.mean)

    def _quantile(self, u: float) -> float:
        return -self.mean * math.log1p(-u)


class _Between(_Kind):
    """A distribution of values between two bounds.

    Attributes:
        low: The minimum of the values.
        high: The maximum of the values.
    """

    low: NotNegative
    high: Positive

    @property
    def least(self) -> float:
        """The minimum of the values."""
        return self.low

    @property
    def greatest(self) -> float:
        """The maximum of the values."""
        return self.high


class Uniform(_Between):
    """The uniform distribution: all values between two bounds are equally likely.

    Attributes:
        low: The minimum of the values.
        high: The maximum of the values.
    """

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low < self.high:
            raise ValueError(f"low {self.low:g} is not less than high {self.high:g}")
        return self

    @property
    def expected(self) -> float:
        """The mean of the values."""
        return (self.low + self.high) / 2

    def value(self, u: float) -> float:
        """Return the value below which a fraction of all values lies."""
        return self.low + u * (self.high - self.low)


class Triangular(_Between):
    """The triangular distribution: values between two bounds, with a most frequent value.

    Attributes:
        low: The minimum of the values.
        mode: The most frequent value.
        high: The maximum of the values.
    """

    mode: NotNegative

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not (self.low <= self.mode <= self.high and self.low < self.high):
            raise ValueError(f"low {self.low:g}, mode {self.mode:g}, high {self.high:g} are not in this order")
        return self

    @property
    def expected(self) -> float:
        """The mean of the values."""
        return (self.low + self.mode + self.high) / 3

    def value(self, u: float) -> float:
        """Return the value below which a fraction of all values lies."""
        span = self.high - self.low
        if u * span < self.mode - self.low:
            return self.low + math.sqrt(u * span * (self.mode - self.low))
        return self.high - math.sqrt((1 - u) * span * (self.high - self.mode))


class Empirical(RootModel[Annotated[tuple[NotNegative, ...], Field(min_length=1, max_length=100_000)]]):
    """One of the values of a list, each with the same probability."""

    model_config = ConfigDict(frozen=True, defer_build=True)

    @cached_property
    def _sorted(self) -> tuple[float, ...]:
        return tuple(sorted(self.root))

    @property
    def least(self) -> float:
        """The minimum of the values."""
        return self._sorted[0]

    @property
    def greatest(self) -> float:
        """The maximum of the values."""
        return self._sorted[-1]

    @property
    def expected(self) -> float:
        """The mean of the values."""
        return math.fsum(self.root) / len(self.root)

    def value(self, u: float) -> float:
        """Return the value below which a fraction of all values lies."""
        return self._sorted[int(u * len(self.root))]


class Distribution(BaseModel):
    """A distribution, such as ``{normal: {mean: 5, stddev: 1}}``; exactly one key.

    Attributes:
        normal: A normal distribution, truncated at 0, or at *min* and *max*.
        lognormal: A log-normal distribution by the mean and standard deviation of its values; may be truncated.
        exponential: An exponential distribution by its mean; may be truncated.
        uniform: A uniform distribution from *low* to *high*.
        triangular: A triangular distribution from *low* to *high* with the most frequent value *mode*.
        empirical: A list of values with equal probability.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True, allow_inf_nan=False)

    normal: Normal | None = None
    lognormal: LogNormal | None = None
    exponential: Exponential | None = None
    uniform: Uniform | None = None
    triangular: Triangular | None = None
    empirical: Empirical | None = None

    @model_validator(mode="after")
    def _one(self) -> Self:
        if len(self._given) != 1:
            raise ValueError(f"expected one distribution of {', '.join(type(self).model_fields)}")
        return self

    @cached_property
    def _given(self) -> list[Normal | LogNormal | Exponential | Uniform | Triangular | Empirical]:
        kinds = (self.normal, self.lognormal, self.exponential, self.uniform, self.triangular, self.empirical)
        return [kind for kind in kinds if kind is not None]

    @property
    def least(self) -> float:
        """The minimum of the values."""
        return self._given[0].least

    @property
    def greatest(self) -> float:
        """The maximum of the values; infinite without a maximum."""
        return self._given[0].greatest

    @property
    def mean(self) -> float:
        """The mean of the values."""
        return self._given[0].expected

    def value(self, u: float) -> float:
        """Return the quantile of a random number: the value below which that fraction of all values lies.

        Args:
            u: More than 0 and less than 1.
        """
        return self._given[0].value(u)


_NAMES: Final = frozenset(Distribution.model_fields)


def is_distribution(value: object) -> bool:
    """Return whether a value, or its form in a file, is a distribution."""
    return isinstance(value, Distribution) or (isinstance(value, dict) and len(value) == 1 and value.keys() <= _NAMES)


def _number_or_distribution(value: Any) -> str:
    return "distribution" if isinstance(value, (dict, Distribution)) else "number"


def _at_most(limit: float) -> Callable[[Distribution], Distribution]:
    def check(value: Distribution) -> Distribution:
        # Seconds may be unbounded, although their limit is finite; factors may not.
        if value.greatest > limit and (limit <= 1.0 or value.greatest < math.inf):
            raise ValueError(f"values up to {value.greatest:g} are possible; expected at most {limit:g}, as with max")
        return value

    return check


RandomValue: TypeAlias = float | Distribution
"""A number, or a distribution that is sampled for each occurrence."""

RandomSeconds = Annotated[
    Annotated[float, SECONDS.field, Tag("number")]
    | Annotated[Distribution, AfterValidator(_at_most(SECONDS.greatest)), Tag("distribution")],
    Discriminator(_number_or_distribution),
]
"""Seconds, or a distribution of seconds that is sampled for each occurrence."""


PositiveRandomSeconds = Annotated[
    Annotated[float, Field(strict=True, gt=0, le=SECONDS.greatest), Tag("number")]
    | Annotated[Distribution, AfterValidator(_at_most(SECONDS.greatest)), Tag("distribution")],
    Discriminator(_number_or_distribution),
]
"""Seconds above 0, or a distribution of seconds."""


def _positive(value: Distribution) -> Distribution:
    if value.least <= 0.0:
        raise ValueError("values down to 0 are possible; expected positive values only, as with min: 0.1")
    return value


RandomFactor = Annotated[
    Annotated[float, Field(strict=True, gt=0, le=1), Tag("number")]
    | Annotated[Distribution, AfterValidator(_at_most(1.0)), AfterValidator(_positive), Tag("distribution")],
    Discriminator(_number_or_distribution),
]
"""A factor above 0 and at most 1, or a distribution of such factors."""


def mean(value: RandomValue) -> float:
    """Return a number, or the mean of a distribution."""
    return value.mean if isinstance(value, Distribution) else value


def latest(value: RandomValue) -> float:
    """Return a number, or the maximum of a distribution, which may be infinite."""
    return value.greatest if isinstance(value, Distribution) else value
