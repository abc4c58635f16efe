"""Intervals, compared with published examples and scipy."""

from __future__ import annotations

import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from hmrsim.experiments.statistics import Interval, mean_interval, proportion_interval, quantile_interval
from tests.cases import case

NUMBERS = st.floats(-1e6, 1e6)


def test_the_mean_of_a_textbook():
    """Law, Simulation Modeling and Analysis, section 4.5: 1.34 ± 0.24 at 90 %."""
    found = mean_interval([1.20, 1.50, 1.68, 1.89, 0.95, 1.49, 1.58, 1.55, 0.50, 1.09], confidence=0.9)

    assert (1.34, 0.24) == (round(found.estimate, 2), round(found.half_width, 2))


@given(st.lists(NUMBERS, min_size=2, max_size=30).filter(lambda values: max(values) - min(values) > 1e-3))
def test_the_mean_is_that_of_scipy(values):
    found = mean_interval(values)

    expected = stats.t.interval(0.95, len(values) - 1, float(stats.tmean(values)), float(stats.sem(values)))
    assert expected == pytest.approx((found.low, found.high), rel=1e-6, abs=1e-6)


def test_few_and_equal_values():
    assert Interval(None, None, None, 0, 0.95) == mean_interval([])
    assert Interval(3.0, None, None, 1, 0.95) == mean_interval([3])
    assert Interval(0.1, 0.1, 0.1, 7, 0.95) == mean_interval([0.1] * 7)
    assert math.inf == mean_interval([3]).half_width


@pytest.mark.parametrize(
    ("successes", "n", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_shares_of_a_published_table(successes, n, low, high):
    """Newcombe 1998, table I, method 3."""
    found = proportion_interval(successes, n)

    assert (low, high) == (round(found.low, 4), round(found.high, 4))


@given(st.integers(0, 500), st.integers(1, 500), st.floats(0.5, 0.999))
def test_shares_are_those_of_scipy(successes, n, confidence):
    successes = min(successes, n)
    found = proportion_interval(successes, n, confidence=confidence)

    expected = stats.binomtest(successes, n).proportion_ci(confidence, "wilson")
    assert (expected.low, expected.high) == pytest.approx((found.low, found.high), abs=1e-9)
    assert 0 <= found.low <= found.estimate <= found.high <= 1


def test_a_share_of_nothing():
    assert Interval(None, 0.0, 1.0, 0, 0.95) == proportion_interval(0, 0)


@pytest.mark.parametrize(("n", "low", "high"), [(5, None, None), (6, 1, 6), (10, 2, 9), (20, 6, 15), (100, 40, 61)])
def test_ranks_of_the_median(n, low, high):
    """As in tables of the sign test: the second and the ninth of ten values."""
    found = quantile_interval([float(rank) for rank in range(1, n + 1)], 0.5)

    assert (low, high) == (found.low, found.high)


def test_a_rare_quantile_needs_many_values():
    """Of 71 values all could be below the 95 % quantile, with 0.95⁷¹ > 2.5 %."""
    assert quantile_interval(range(71), 0.95).high is None
    assert 71.0 == quantile_interval(range(72), 0.95).high
    assert Interval(None, None, None, 0, 0.95) == quantile_interval([], 0.5)


@given(st.integers(1, 200), st.floats(0.01, 0.99), st.floats(0.5, 0.99))
def test_ranks_have_the_confidence(n, share, confidence):
    """The number of values up to the quantile is outside with just under (1 - confidence) / 2 on either side."""
    found = quantile_interval([float(rank) for rank in range(1, n + 1)], share, confidence=confidence)
    count, half = stats.binom(n, share), (1 - confidence) / 2 + 1e-9

    low, high = found.low or 0.0, found.high or n + 1.0
    assert count.cdf(low - 1) <= half <= count.cdf(low) + 2e-9
    assert count.sf(high - 1) <= half <= count.sf(high - 2) + 2e-9


def test_intervals_contain_the_mean_with_their_confidence():
    """Of normal values, within the chance of 2,000 experiments."""
    chance = random.Random(3)
    found = [mean_interval([chance.gauss(5, 2) for _ in range(8)]) for _ in range(2000)]

    assert 0.935 < sum(one.low <= 5 <= one.high for one in found) / len(found) < 0.965


def test_rejects_invalid_arguments():
    for text, act in {
        "value 1 is nan; expected numbers up to 1e": lambda: mean_interval([1.0, math.nan]),
        "confidence must be between 0 and 1, got 95": lambda: mean_interval([1.0, 2.0], confidence=95),
        "3 successes of 2; expected 0 to 2": lambda: proportion_interval(3, 2),
        "share must be between 0 and 1, got 1": lambda: quantile_interval([1.0], 1),
    }.items():
        with case(text), pytest.raises(ValueError, match=text):
            act()
