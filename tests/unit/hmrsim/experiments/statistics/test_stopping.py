"""Rules for when an experiment stops replicating."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.experiments.statistics import (
    PROPORTION,
    StoppingRule,
    enough,
    mean_interval,
    proportion_interval,
    replications_needed,
)
from tests.cases import case

CALM = [100.0, 101.0, 99.0, 100.5, 99.5, 100.0, 100.2, 99.8, 100.1, 99.9]


def stops(values, rule):
    """Return the number of values after which the rule stops."""
    return next((n for n in range(len(values) + 1) if enough(values[:n], rule)), None)


def test_the_look_ahead_follows_the_first_narrow_interval():
    """The first three values are precise; with kLimit = 5, eight are needed."""
    assert 3 == stops(CALM, StoppingRule(0.05, look_ahead=0))
    assert 8 == stops(CALM, StoppingRule(0.05))


def test_the_look_ahead_finds_a_premature_stop():
    """Three values are close by chance, as the next ones show."""
    early = [100.0, 100.1, 99.9, 150.0, 60.0, *CALM]

    assert 3 == stops(early, StoppingRule(0.05, look_ahead=0))
    assert stops(early, StoppingRule(0.05)) is None


def test_the_look_ahead_grows_beyond_a_hundred():
    """For n above 100 it is kLimit n / 100 (Hoad, Robinson and Davies, 2010)."""
    values = [100.0, 101.0] * 250
    first = next(n for n in range(3, 500) if mean_interval(values[:n]).half_width / 100.5 <= 0.0005)

    assert first > 100
    assert first + 5 * first // 100 == stops(values, StoppingRule(0.0005))


def test_minimum_and_maximum():
    assert 10 == stops(CALM, StoppingRule(0.05, minimum=10, look_ahead=0))
    assert 4 == stops([1.0, 1000.0] * 5, StoppingRule(0.01, maximum=4))


def test_equal_values_and_a_mean_of_zero():
    assert 8 == stops([0.0] * 20, StoppingRule(0.05))
    assert stops([-1.0, 1.0] * 10, StoppingRule(0.05)) is None
    assert replications_needed([-1.0, 1.0], StoppingRule(0.05)) is None
    assert 50 == replications_needed([-1.0, 1.0], StoppingRule(0.05, maximum=50))
    assert replications_needed([7.0], StoppingRule(0.05)) is None


def test_a_share_of_runs():
    values = [1.0, 0.0] * 300
    rule = StoppingRule(0.05, of=PROPORTION, look_ahead=0)
    found = stops(values, rule)

    assert proportion_interval(found // 2, found).half_width <= 0.05
    assert 0.05 < proportion_interval((found - 1) // 2, found - 1).half_width
    assert abs(found - replications_needed(values[:20], rule)) <= 2


def test_estimates_the_replications_needed():
    """(t s / (0.05 mean))²: 19 for a standard deviation of a tenth, plus five to look ahead."""
    values = [90.0, 110.0, 100.0, 90.0, 110.0, 100.0, 100.0, 85.0, 115.0]

    assert 9 == len(values)
    assert 19 + 5 == replications_needed(values, StoppingRule(0.05))
    assert 12 == replications_needed(values, StoppingRule(0.05, maximum=12))


@given(st.lists(st.floats(0, 100), max_size=40), st.floats(0.01, 1), st.integers(0, 6))
def test_further_values_stay_enough(values, error, look_ahead):
    rule = StoppingRule(error, look_ahead=look_ahead, maximum=35)
    answers = [enough(values[:n], rule) for n in range(len(values) + 1)]

    assert sorted(answers) == answers
    assert len(values) < 35 or answers[-1]


def test_means_are_precise_after_a_stop():
    """With lognormal times, 95 % intervals contain the mean in at least 90 % of experiments: stopping costs some."""
    chance = random.Random(5)
    right = 0
    for _ in range(200):
        values = [chance.lognormvariate(0, 0.3) for _ in range(300)]
        found = mean_interval(values[: stops(values, StoppingRule(0.1, minimum=5))])
        right += found.low <= 1.0460278599 <= found.high

    assert right >= 180


def test_rejects_invalid_rules():
    for text, settings in {
        "error must be positive, got 0": {"error": 0},
        "no rule for 'median'; there are mean, proportion": {"error": 1, "of": "median"},
        "minimum must be 3 or more, got 2": {"error": 1, "minimum": 2},
        "maximum must be 8 or more, as the minimum, got 5": {"error": 1, "minimum": 8, "maximum": 5},
        "look_ahead must be 0 or more, got -1": {"error": 1, "look_ahead": -1},
    }.items():
        with case(text), pytest.raises(ValueError, match=text):
            StoppingRule(**settings)
    with pytest.raises(ValueError, match=r"value 2 is 0\.5; expected 0 or 1 for a proportion"):
        enough([1, 0, 0.5], StoppingRule(0.1, of=PROPORTION))
