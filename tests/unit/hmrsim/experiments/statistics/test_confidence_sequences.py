"""Confidence sequences, which you can look at after each pair."""

from __future__ import annotations

import itertools
import math
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.experiments.statistics import Interval, confidence_sequence, confidence_sequences, mean_interval
from hmrsim.experiments.statistics.confidence_sequences import first_above
from tests.profiles import examples

NUMBERS = st.floats(-100, 100).map(lambda value: round(value, 3))
SIGNS = st.sampled_from([-1, 0, 1])


@pytest.mark.parametrize("sizes", [[1.0] * 12, [3.0, 1.0, 2.0, 5.0, 1.5, 1.0, 4.0, 1.1, 2.2, 0.9, 7.0, 2.0]])
def test_the_level_holds_exactly_for_all_signs(sizes, monkeypatch):
    """Few of the 4,096 equally likely signs of these differences seem to be above 0, with a first look after five."""
    monkeypatch.setattr(confidence_sequences, "FIRST_LOOK", 5)
    ways = list(itertools.product((-1, 1), repeat=len(sizes)))
    found = [
        first_above([sign * size for sign, size in zip(way, sizes, strict=True)], 0.0, 0.2, yes_no=False)
        for way in ways
    ]

    assert 0 < sum(one is not None for one in found) / len(ways) <= 0.1


@pytest.mark.parametrize(("less", "more"), [(0.3, 0.3), (0.1, 0.1), (0.5, 0.5), (0.2, 0.4)])
def test_the_level_holds_exactly_for_yes_and_no(less, more):
    """Over all outcomes of eight pairs, the bound is rarely above the true mean."""
    chances = {-1: less, 0: 1 - less - more, 1: more}
    wrong = math.fsum(
        math.prod(chances[one] for one in way)
        for way in itertools.product((-1, 0, 1), repeat=8)
        if first_above(way, more - less, 0.4, yes_no=True) is not None
    )

    assert wrong <= 0.2


def test_few_differences_have_no_bounds():
    """Real numbers have no bounds before 30 differences; shares have theirs."""
    assert Interval(None, None, None, 0, 0.95) == confidence_sequence([])
    assert Interval(None, -1.0, 1.0, 0, 0.95) == confidence_sequence([], yes_no=True)
    assert Interval(2.0, None, None, 27, 0.95) == confidence_sequence([1, 2, 3] * 9)
    assert None not in {(found := confidence_sequence([1, 2, 3] * 10)).low, found.high}
    assert first_above([], 0.0, 0.05, yes_no=False) is None


def test_equal_differences():
    assert Interval(0.0, None, None, 100, 0.95) == confidence_sequence([0.0] * 100)
    found = confidence_sequence([2.0] * 100)
    assert 2.0 == pytest.approx(found.low) == pytest.approx(found.high)
    found = confidence_sequence([0] * 100, yes_no=True)
    assert -0.06 < found.low < 0.0 < found.high < 0.06


@given(st.lists(NUMBERS, max_size=45), st.booleans())
@examples(60)
def test_bounds_only_become_narrower(values, yes_no):
    """Bounds are widened only to include the mean, and are never the wrong way round."""
    given_ = [(value > 50) - (value < -50) for value in values] if yes_no else values
    found = [confidence_sequence(given_[:n], yes_no=yes_no, confidence=0.5) for n in range(len(given_) + 1)]

    for before, after in itertools.pairwise(found):
        assert before.low is None or after.low >= min(before.low, after.estimate) - 1e-6
        assert before.high is None or after.high <= max(before.high, after.estimate) + 1e-6
    assert all(one.low is None or one.high is None or one.low <= one.high for one in found)


@given(st.lists(NUMBERS, min_size=30, max_size=45), st.integers(-4, 4))
@examples(60)
def test_units_do_not_matter(values, power):
    found = confidence_sequence(values)
    scaled = confidence_sequence([value * 2.0**power for value in values])
    mirrored = confidence_sequence([-value for value in values])

    for one, bound in ((scaled.low, found.low), (scaled.high, found.high)):
        assert (one is None) == (bound is None)
        assert one is None or one == pytest.approx(bound * 2.0**power, rel=1e-6, abs=1e-9)
    assert (found.low is None) == (mirrored.high is None)
    assert found.low is None or found.low == pytest.approx(-mirrored.high)


@given(st.lists(SIGNS, min_size=5, max_size=40), st.floats(-0.9, 0.9))
@examples(60)
def test_bounds_are_the_values_that_looks_exclude(values, value):
    known = first_above(values, value, 0.05, yes_no=True) is not None
    found = confidence_sequence(values, yes_no=True)

    assert known == (found.low > value) or found.low == pytest.approx(value, abs=1e-6)


def test_bounds_of_a_mean_that_changes_are_those_of_the_last_look():
    """The first eighty differences are all near 1, so the intersection is empty."""
    found = confidence_sequence([1.0, 1.1, 0.9, 1.05] * 20 + [-1.0, -1.1, -0.9, -1.05] * 500)

    assert found.low < found.estimate < found.high
    assert found.high - found.low < 0.2


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=80))
def test_an_interval_contains_its_own_estimate(differences):
    found = confidence_sequence(differences)

    assert found.low is None or found.low <= found.estimate
    assert found.high is None or found.estimate <= found.high


@pytest.mark.parametrize("yes_no", [False, True])
def test_the_mean_stays_within(yes_no):
    """In 300 experiments of 60 pairs with a look after each, at most 5 % exclude the mean."""
    chance = random.Random(11)
    draw = (lambda: float(chance.choices((-1, 0, 1), (1, 6, 3))[0])) if yes_no else (lambda: chance.gauss(0.2, 3))
    found = [confidence_sequence([draw() for _ in range(60)], yes_no=yes_no) for _ in range(300)]

    outside = sum((one.low is not None and one.low > 0.2) or (one.high is not None and one.high < 0.2) for one in found)
    assert outside <= 15


def test_looking_always_costs_some_width():
    """On average, the width is one to two times that of Student's interval."""
    chance = random.Random(2)
    ratios = []
    for _ in range(20):
        values = [chance.gauss(0, 1) for _ in range(200)]
        ratios.append(confidence_sequence(values).half_width / mean_interval(values).half_width)

    assert 1 < math.fsum(ratios) / len(ratios) < 2


def test_differences_of_yes_and_no():
    with pytest.raises(ValueError, match=r"difference 1 is 0\.5; expected -1, 0 or 1"):
        confidence_sequence([1, 0.5], yes_no=True)
    with pytest.raises(ValueError, match="value 0 is inf; expected numbers up to 1e"):
        confidence_sequence([math.inf])
