"""Distributions of random values in world files."""

from __future__ import annotations

import math
import statistics
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from hmrsim.distributions import Distribution, RandomFactor, RandomSeconds, latest, mean

SECONDS: TypeAdapter[Any] = TypeAdapter(RandomSeconds)
FACTOR: TypeAdapter[Any] = TypeAdapter(RandomFactor)

ALL = [
    {"normal": {"mean": 5, "stddev": 1}},
    {"normal": {"mean": 1, "stddev": 2, "min": 0.5, "max": 4}},
    {"lognormal": {"mean": 5, "stddev": 3}},
    {"lognormal": {"mean": 5, "stddev": 3, "max": 8}},
    {"exponential": {"mean": 4}},
    {"exponential": {"mean": 4, "min": 1, "max": 6}},
    {"uniform": {"low": 1, "high": 3}},
    {"triangular": {"low": 1, "mode": 2, "high": 6}},
    {"triangular": {"low": 1, "mode": 6, "high": 6}},
    {"empirical": [3, 1, 2, 2]},
]


def values(distribution: Distribution, n: int = 20_000) -> list[float]:
    return [distribution.value((i + 0.5) / n) for i in range(n)]


@pytest.mark.parametrize("data", ALL, ids=str)
def test_mean_and_bounds_fit_the_values(data: dict[str, Any]) -> None:
    distribution = SECONDS.validate_python(data)
    drawn = values(distribution)
    assert mean(distribution) == pytest.approx(statistics.fmean(drawn), rel=2e-3)
    assert distribution.least <= drawn[0] <= drawn[-1] <= latest(distribution)
    assert drawn == sorted(drawn)


@pytest.mark.parametrize(
    ("data", "stddev"),
    [
        ({"normal": {"mean": 50, "stddev": 2}}, 2),
        ({"lognormal": {"mean": 5, "stddev": 3}}, 3),
        ({"exponential": {"mean": 4}}, 4),
        ({"uniform": {"low": 1, "high": 3}}, 2 / math.sqrt(12)),
        ({"triangular": {"low": 1, "mode": 2, "high": 6}}, math.sqrt((1 + 4 + 36 - 2 - 6 - 12) / 18)),
    ],
    ids=str,
)
def test_the_standard_deviation_has_the_textbook_value(data: dict[str, Any], stddev: float) -> None:
    assert statistics.pstdev(values(SECONDS.validate_python(data), 200_000)) == pytest.approx(stddev, rel=2e-2)


def test_a_truncated_normal_is_the_part_between_its_bounds() -> None:
    cut = SECONDS.validate_python({"normal": {"mean": 1, "stddev": 2, "min": 0.5, "max": 4}})
    whole = statistics.NormalDist(1, 2)
    share = (whole.cdf(2.0) - whole.cdf(0.5)) / (whole.cdf(4.0) - whole.cdf(0.5))
    assert cut.value(share) == pytest.approx(2.0)


@given(u=st.floats(1e-12, 1 - 1e-12), data=st.sampled_from(ALL))
def test_each_random_number_gives_a_value_within_the_bounds(u: float, data: dict[str, Any]) -> None:
    distribution = SECONDS.validate_python(data)
    assert distribution.least <= distribution.value(u) <= distribution.greatest


def test_a_number_is_its_own_value() -> None:
    assert SECONDS.validate_python(2) == mean(2.0) == latest(2.0) == 2.0


@pytest.mark.parametrize(
    ("data", "wrong"),
    [
        ({}, "expected one distribution of normal, lognormal, exponential, uniform, triangular, empirical"),
        ({"uniform": {"low": 1, "high": 2}, "exponential": {"mean": 1}}, "expected one distribution of"),
        ({"uniform": {"low": 3, "high": 2}}, "low 3 is not less than high 2"),
        ({"triangular": {"low": 1, "mode": 9, "high": 3}}, "low 1, mode 9, high 3 are not in this order"),
        ({"normal": {"mean": 5, "stddev": 1, "min": 6, "max": 4}}, "min 6 is not less than max 4"),
        ({"normal": {"mean": -900, "stddev": 1}}, "there are no values from 0 to inf"),
        ({"uniform": {"low": 1, "high": 2e9}}, "less than or equal to 1000000000"),
        ({"empirical": []}, "at least 1 item"),
        ({"empirical": [-1]}, "greater than or equal to 0"),
        ("soon", "valid number"),
        (-1, "greater than or equal to 0"),
    ],
    ids=str,
)
def test_invalid_distributions_of_seconds_are_rejected(data: object, wrong: str) -> None:
    with pytest.raises(ValidationError, match=wrong.replace("(", r"\(")):
        SECONDS.validate_python(data)


@pytest.mark.parametrize(
    ("data", "wrong"),
    [
        ({"uniform": {"low": 0.5, "high": 2}}, "values up to 2 are possible; expected at most 1"),
        ({"exponential": {"mean": 0.5}}, "values up to inf are possible"),
        ({"uniform": {"low": 0, "high": 1}}, "values down to 0 are possible"),
        (0, "greater than 0"),
        (1.5, "less than or equal to 1"),
    ],
    ids=str,
)
def test_invalid_factors_are_rejected(data: object, wrong: str) -> None:
    with pytest.raises(ValidationError, match=wrong):
        FACTOR.validate_python(data)
