"""Means, standard deviations and skewness of the first values."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.experiments.statistics.summaries import asymmetries
from tests.profiles import examples


@given(st.lists(st.integers(-1000, 1000), min_size=1, max_size=30), st.sampled_from([0.0, 1e6]))
@examples(60)
def test_asymmetries_are_the_third_central_moment_over_the_second(values, offset):
    """Of each number of first values, also far from 0; without any spread there is none."""
    found = asymmetries([value + offset for value in values])

    for n, one in enumerate(found, 1):
        deviations = np.asarray(values[:n], float) - np.mean(values[:n])
        spread = (deviations**2).mean()
        assert one == pytest.approx((deviations**3).mean() / spread if spread else 0.0, rel=1e-6, abs=1e-5)
