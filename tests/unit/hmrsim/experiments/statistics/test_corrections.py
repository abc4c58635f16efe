"""Several p-values at once."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.experiments.statistics import holm

SHARES = st.floats(0, 1)


@pytest.mark.parametrize(
    ("given_", "adjusted"),
    [
        ([0.01, 0.04, 0.03, 0.005], [0.03, 0.06, 0.06, 0.02]),
        ([0.01, 0.02, 0.03, 0.04, 0.05], [0.05, 0.08, 0.09, 0.09, 0.09]),
        ([0.6, 0.7], [1.0, 1.0]),
        ([0.04], [0.04]),
        ([], []),
    ],
)
def test_adjusted_values(given_, adjusted):
    """As R's p.adjust(p, "holm") gives them."""
    assert tuple(adjusted) == pytest.approx(holm(given_))


@given(st.lists(SHARES, max_size=10))
def test_between_the_p_value_and_bonferroni(values):
    """Never less than the p-value itself, never more than Bonferroni's, in the same order, equal ones equal."""
    adjusted = holm(values)

    assert all(p <= one <= min(1, len(values) * p) for p, one in zip(values, adjusted, strict=True))
    assert sorted(adjusted) == [one for _, one in sorted(zip(values, adjusted, strict=True))]


def test_a_p_value_is_a_share():
    """Others are refused."""
    with pytest.raises(ValueError, match=r"p-value 1 is 1\.5; expected 0 to 1"):
        holm([0.1, 1.5])
