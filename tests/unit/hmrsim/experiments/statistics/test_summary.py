"""Columns in short."""

from __future__ import annotations

import statistics

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.experiments.statistics import Summary, quantile, summary

NUMBERS = st.floats(-1e6, 1e6)


def test_a_column_with_gaps():
    """What is missing is counted and left out."""
    expected = Summary(3, 2, 4.0, pytest.approx(2.0), 2.0, 6.0, {0.5: 4.0, 0.25: 3.0})

    assert expected == summary([4, None, 2, None, 6], [0.5, 0.25])


def test_columns_of_little():
    """Nothing has nothing; one value no spread."""
    assert Summary(0, 1, None, None, None, None, {}) == summary([None])
    assert Summary(1, 0, 5.0, None, 5.0, 5.0, {0.5: 5.0}) == summary([5], [0.5])


@given(st.lists(NUMBERS, min_size=2, max_size=30))
def test_quantiles_are_those_of_python(values):
    """By straight lines between the values, which include the least and the most."""
    ordered = sorted(values)
    tenths = statistics.quantiles(ordered, n=10, method="inclusive")

    assert tenths == pytest.approx([quantile(ordered, share / 10) for share in range(1, 10)], abs=1e-6)
    assert (ordered[0], ordered[-1]) == (quantile(ordered, 0), quantile(ordered, 1))


@given(st.lists(NUMBERS, min_size=2, max_size=30))
def test_mean_and_spread_are_those_of_python(values):
    """Up to rounding."""
    found = summary(values)

    assert (statistics.fmean(values), statistics.stdev(values)) == pytest.approx((found.mean, found.stddev), abs=1e-6)


def test_quantiles_that_are_none():
    """Of nothing, and of shares outside 0 and 1."""
    with pytest.raises(ValueError, match="no values; expected one at least"):
        quantile([], 0.5)
    with pytest.raises(ValueError, match="share must be within 0 and 1, got 95"):
        quantile([1.0], 95)
