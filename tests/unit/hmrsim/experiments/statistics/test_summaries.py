"""Summaries of the columns of results."""

from __future__ import annotations

import statistics
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.errors import MissingExtra
from hmrsim.experiments.statistics import (
    Summary,
    confidence_sequence,
    mean_interval,
    proportion_interval,
    quantile,
    summary,
)
from hmrsim.experiments.statistics.summaries import asymmetries
from tests.profiles import examples

NUMBERS = st.floats(-1e6, 1e6)


def test_a_column_with_gaps():
    expected = Summary(3, 2, 4.0, pytest.approx(2.0), 2.0, 6.0, {0.5: 4.0, 0.25: 3.0})

    assert expected == summary([4, None, 2, None, 6], [0.5, 0.25])


def test_columns_of_one_or_no_value():
    assert Summary(0, 1, None, None, None, None, {}) == summary([None])
    assert Summary(1, 0, 5.0, None, 5.0, 5.0, {0.5: 5.0}) == summary([5], [0.5])


@given(st.lists(NUMBERS, min_size=2, max_size=30))
def test_quantiles_are_those_of_python(values):
    ordered = sorted(values)
    tenths = statistics.quantiles(ordered, n=10, method="inclusive")

    assert tenths == pytest.approx([quantile(ordered, share / 10) for share in range(1, 10)], abs=1e-6)
    assert (ordered[0], ordered[-1]) == (quantile(ordered, 0), quantile(ordered, 1))


@given(st.lists(NUMBERS, min_size=2, max_size=30))
def test_mean_and_spread_are_those_of_python(values):
    found = summary(values)

    assert (statistics.fmean(values), statistics.stdev(values)) == pytest.approx((found.mean, found.stddev), abs=1e-6)


def test_rejects_quantiles_of_nothing_and_invalid_shares():
    with pytest.raises(ValueError, match="no values; expected one at least"):
        quantile([], 0.5)
    with pytest.raises(ValueError, match="share must be within 0 and 1, got 95"):
        quantile([1.0], 95)


@given(st.lists(st.integers(-1000, 1000), min_size=1, max_size=30), st.sampled_from([0.0, 1e6]))
@examples(60)
def test_asymmetries_are_the_third_central_moment_over_the_second(values, offset):
    found = asymmetries([value + offset for value in values])

    for n, one in enumerate(found, 1):
        deviations = np.asarray(values[:n], float) - np.mean(values[:n])
        spread = (deviations**2).mean()
        assert one == pytest.approx((deviations**3).mean() / spread if spread else 0.0, rel=1e-6, abs=1e-5)


@pytest.mark.parametrize(
    ("missing", "act"),
    [
        ("scipy.stats", lambda: mean_interval([1.0, 2.0])),
        ("scipy.optimize", lambda: confidence_sequence([1.0, 2.0] * 20)),
        ("numpy", lambda: confidence_sequence([1.0, 2.0])),
    ],
)
def test_missing_library_names_the_extra(monkeypatch, missing, act):
    monkeypatch.setitem(sys.modules, missing, None)

    with pytest.raises(MissingExtra, match=r"need scipy; pip install 'hmrsim\[experiments\]'"):
        act()


def test_package_is_imported_without_its_libraries():
    program = (
        "import sys; sys.modules.update(scipy=None, numpy=None); from hmrsim.experiments import statistics; "
        "print(round(statistics.proportion_interval(0, 20).high, 4))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)

    assert "0.1611\n" == done.stdout, done.stderr
    assert proportion_interval(0, 20).high < 1
