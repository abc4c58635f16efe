"""Effects of factors and of treatments, against published examples."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from hmrsim.experiments.statistics import (
    interactions,
    main_effects,
    mean_interval,
    paired_difference,
    unpaired_difference,
)

# Hours of sleep that two drugs gave to the same ten people: Student 1908, after Cushny and Peebles.
DEXTRO = [0.7, -1.6, -0.2, -1.2, -0.1, 3.4, 3.7, 0.8, 0.0, 2.0]
LAEVO = [1.9, 0.8, 1.1, 0.1, -0.1, 4.4, 5.5, 1.6, 4.6, 3.4]

# Yield of a reaction by concentration and catalyst: Montgomery, Design and Analysis of Experiments, section 6.2.
YIELDS = {(-1, -1): [28, 25, 27], (1, -1): [36, 32, 32], (-1, 1): [18, 19, 23], (1, 1): [31, 30, 29]}

VALUES = st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=12).filter(lambda values: max(values) - min(values) > 0.1)


def reaction():
    """Return the runs of the reaction, and their yields."""
    runs = [({"a": a, "b": b}, value) for (a, b), values in YIELDS.items() for value in values]
    return [run for run, _ in runs], [value for _, value in runs]


def test_students_own_example():
    """Paired: 1.58 hours, t = 4.06 with 9 degrees of freedom, p = 0.0028; between 0.70 and 2.46."""
    found = paired_difference(DEXTRO, LAEVO)

    assert (1.58, 4.0621, 9, 0.002833) == pytest.approx(
        (found.interval.estimate, found.statistic, found.degrees, found.p), rel=1e-3
    )
    assert (0.7001, 2.4599) == pytest.approx((found.interval.low, found.interval.high), abs=1e-4)


def test_welch_of_the_same_numbers():
    """As R has it in its manual: t = 1.8608 with 17.776 degrees of freedom, p = 0.07939, -0.205 to 3.365."""
    found = unpaired_difference(DEXTRO, LAEVO)

    assert (1.8608, 17.776, 0.07939) == pytest.approx((found.statistic, found.degrees, found.p), rel=1e-4)
    assert (-0.2054832, 3.3654832) == pytest.approx((found.interval.low, found.interval.high), abs=1e-6)
    assert 20 == found.interval.n


@given(VALUES, VALUES)
def test_welch_is_that_of_scipy(a, b):
    found, expected = unpaired_difference(a, b), stats.ttest_ind(b, a, equal_var=False)

    assert (expected.statistic, expected.pvalue, expected.df) == pytest.approx(
        (found.statistic, found.p, found.degrees), rel=1e-6, abs=1e-9
    )


def test_too_few_and_equal_runs():
    assert (2.0, None, None) == (paired_difference([1], [3]).interval.estimate, *[paired_difference([1], [3]).p] * 2)
    assert (0.0, 1.0) == (paired_difference([1, 2], [1, 2]).statistic, paired_difference([1, 2], [1, 2]).p)
    assert (math.inf, 0.0) == (paired_difference([1, 2], [2, 3]).statistic, paired_difference([1, 2], [2, 3]).p)
    assert (-math.inf, 2) == (
        unpaired_difference([2, 2], [1, 1]).statistic,
        unpaired_difference([2, 2], [1, 1]).degrees,
    )
    assert unpaired_difference([1], []).interval.estimate is None
    with pytest.raises(ValueError, match="2 values of A and 1 of B; expected one of each for each seed"):
        paired_difference([1, 2], [1])


def test_main_effects_of_a_textbook():
    """High against low: 8.33 for the concentration, -5.00 for the catalyst."""
    found = {(one.factor, one.level): one for one in main_effects(*reaction())}

    assert 8.333 == pytest.approx(found["a", 1].mean.estimate - found["a", -1].mean.estimate, abs=1e-3)
    assert -5.0 == pytest.approx(found["b", 1].effect - found["b", -1].effect)
    assert mean_interval([28, 25, 27, 18, 19, 23]) == found["a", -1].mean


def test_interactions_of_a_textbook():
    """1.67 for both together, which is half of the difference to the sum of both effects."""
    found = {one.levels: one.effect for one in interactions(*reaction())}

    assert {(1, 1): 0.8333, (-1, -1): 0.8333, (1, -1): -0.8333, (-1, 1): -0.8333} == pytest.approx(found, abs=1e-4)


def test_effects_that_add_up_have_no_interactions():
    runs = [dict(zip("abc", levels, strict=True)) for levels in itertools.product((0, 1, 5), repeat=3)]
    values = [run["a"] + 10 * run["b"] - 3 * run["c"] for run in runs]

    assert [0.0] * 27 == pytest.approx([one.effect for one in interactions(runs, values)], abs=1e-9)
    assert [-2, -1, 3] == pytest.approx([one.effect for one in main_effects(runs, values) if one.factor == "a"])


def test_an_unbalanced_design():
    """Each level has the mean of its own runs, and an interval if there are two."""
    found = main_effects([{"a": "x"}, {"a": "x"}, {"a": "y"}], [1.0, 3.0, 8.0])

    assert [("x", 2.0, -2.0), ("y", 8.0, 4.0)] == [(one.level, one.mean.estimate, one.effect) for one in found]
    assert found[1].mean.low is None


def test_rejects_different_factors_and_missing_values():
    assert () == main_effects([], []) == interactions([], [])
    with pytest.raises(ValueError, match="run 1 has the factors b; expected a"):
        main_effects([{"a": 1}, {"b": 1}], [1, 2])
    with pytest.raises(ValueError, match="1 runs and 2 values; expected one value for each run"):
        main_effects([{"a": 1}], [1, 2])
