"""Verdicts: better, worse, equivalent or undecided."""

from __future__ import annotations

import math
import random
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.experiments.statistics import Comparison, Criterion, Interval, compare, compare_all, holm, verdict
from hmrsim.experiments.statistics.confidence_sequences import first_above
from tests.cases import case
from tests.profiles import examples

SMALLER = Criterion(larger_is_better=False)
LARGER = Criterion(larger_is_better=True)
SHARES = Criterion(larger_is_better=True, margin=0.1, yes_no=True)

DRAWS = {
    "normal": lambda z: z,
    "lognormal": math.exp,
    "heavy tails": lambda z: z**3,
    "whole numbers": lambda z: float(round(z)),
    "yes and no": lambda z: float(z > 0),
}


def runs(chance, draw, pairs, rho=0.8):
    """Return correlated values of A and B, as under common seeds."""
    common = [chance.gauss(0, 1) for _ in range(pairs)]
    other = [rho * z + math.sqrt(1 - rho**2) * chance.gauss(0, 1) for z in common]
    return [draw(z) for z in common], [draw(z) for z in other]


@pytest.mark.parametrize("name", DRAWS)
def test_a_against_a_is_hardly_ever_better_or_worse(name):
    """At most 5 % of 400 experiments of 60 pairs with a look after each."""
    chance = random.Random(name)
    criterion = Criterion(larger_is_better=True, yes_no=name == "yes and no")
    found = [verdict(*runs(chance, DRAWS[name], 60), criterion)[0] for _ in range(400)]

    assert found.count("better") + found.count("worse") <= 20


EQUAL_MEANS = {
    "lognormal, 0.7 and 1 under common seeds": lambda chance: (
        lognormal(z := chance.gauss(0, 1), 1.0) - lognormal(z, 0.7)
    ),
    "lognormal, 0.5 and 1.5": lambda chance: lognormal(chance.gauss(0, 1), 1.5) - lognormal(chance.gauss(0, 1), 0.5),
    "constant and lognormal, 1": lambda chance: lognormal(chance.gauss(0, 1), 1.0) - 1,
    "constant and exponential": lambda chance: chance.expovariate(1) - 1,
    "uniform and yes or no": lambda chance: (chance.random() < 0.1) - 0.2 * chance.random(),
}
"""B - A, of measures that differ in their shapes alone."""


def lognormal(z, stddev):
    """Return a lognormal number whose mean is 1."""
    return math.exp(stddev * z - stddev**2 / 2)


@pytest.mark.parametrize("name", EQUAL_MEANS)
def test_equal_means_of_other_shapes_are_seldom_better_or_worse(name):
    """At most 10 % of 300 experiments of 80 pairs with a look after each, including withdrawn verdicts."""
    chance, false = random.Random(name), 0
    for _ in range(300):
        differences = [EQUAL_MEANS[name](chance) for _ in range(80)]
        sides = differences, [-difference for difference in differences]
        false += any(first_above(side, 0.0, 0.05, yes_no=False) for side in sides)

    assert false <= 30


def test_a_real_difference_is_found():
    """Half a standard deviation takes 66 runs on average; Welch's test takes 172 for a power of 0.9."""
    chance = random.Random(1)
    found = []
    for _ in range(100):
        a, b = runs(chance, DRAWS["normal"], 86)
        found.append(verdict(a, [value + 0.5 for value in b], LARGER))

    assert 90 <= [said for said, _ in found].count("better")
    assert sum(2 * (after or 86) for _, after in found) / len(found) < 172 / 2


@given(st.lists(st.tuples(st.integers(0, 20), st.integers(0, 20)), min_size=30, max_size=60), st.booleans())
@examples(60)
def test_a_verdict_stands(pairs, relative):
    """Further pairs can only withdraw a verdict."""
    criterion = Criterion(larger_is_better=False, margin=0.5, relative=relative, yes_no=False, alpha=0.5)
    a, b = [one for one, _ in pairs], [other for _, other in pairs]
    looks = [verdict(a[:n], b[:n], criterion) for n in range(len(pairs) + 1)]

    first = next((n for n, (said, _) in enumerate(looks) if said != "undecided"), len(looks))

    for n, look in enumerate(looks[first:], first):
        assert look == looks[first] or looks[first][0] in compare(a[:n], b[:n], criterion).withdrawn


def test_directions():
    a, b = [10.0, 12.0, 11.0] * 10, [13.0, 15.5, 14.0] * 10

    assert ("worse", "better") == (verdict(a, b, SMALLER)[0], verdict(a, b, LARGER)[0])
    assert ("better", "worse") == (verdict(b, a, SMALLER)[0], verdict(b, a, LARGER)[0])


def test_comparison_has_bounds_and_differing_pairs():
    found = compare([1, 0] * 30, [1, 1] * 30, SHARES)

    assert ("better", 16, 30, 0.5) == (found.verdict, found.decided_after, found.differing, found.difference.estimate)
    assert 0.2 < found.difference.low < 0.5 < found.difference.high < 0.8


def test_identical_runs():
    """A against itself is equivalent after 59 pairs."""
    times = [float(number) for number in range(100)]
    within = Criterion(larger_is_better=False, margin=1.0)

    assert ("undecided", None) == verdict(times[:58], times[:58], within)
    assert ("equivalent", 59) == verdict(times, times, within)
    assert ("equivalent", 59) == verdict(times, times, Criterion(larger_is_better=False, margin=0.5, relative=True))
    assert ("equivalent", 90) == verdict(times, times, Criterion(larger_is_better=False, margin=1.0, alpha=0.01))
    assert Comparison("undecided", None, Interval(0.0, None, None, 100, 0.95), 0) == compare(times, times, SMALLER)


def test_identical_yes_and_no():
    assert ("equivalent", 53) == verdict([1] * 100, [1] * 100, SHARES)


def test_values_that_are_all_0_or_1_are_of_yes_and_no():
    """Unless the margin shows that they are not, or none of them is 1."""
    a, b = [0.0, 1.0, 0.0, 0.0] * 20, [1.0, 1.0, 0.0, 1.0] * 20
    wide = Criterion(larger_is_better=True, margin=1.0)
    few = Criterion(larger_is_better=True, margin=0.3, relative=True)

    assert compare(a, b, replace(SHARES, margin=None)) == compare(a, b, LARGER)
    assert compare(a, b, SHARES) == compare(a, b, replace(SHARES, yes_no=None))
    assert compare(a, b, replace(wide, yes_no=False)) == compare(a, b, wide) != compare(a, b, LARGER)
    assert compare([*a, 2.0], [*b, 2.0], replace(LARGER, yes_no=False)) == compare([*a, 2.0], [*b, 2.0], LARGER)
    assert None is compare([0.0] * 80, [0.0] * 80, LARGER).difference.low
    assert "better" == verdict(a, b, few)[0]
    assert ("equivalent", ()) == ((found := compare(b * 3, b * 3, few)).verdict, found.withdrawn)


def test_a_false_equivalence_of_yes_and_no_is_rare_by_a_relative_margin():
    """At most 5 % of 200 experiments of 100 pairs, with B's share a tenth above A's and a margin of a tenth."""
    chance = random.Random(9)
    criterion = Criterion(larger_is_better=True, margin=0.1, relative=True)
    found = []
    for _ in range(200):
        ranks = [chance.random() for _ in range(100)]
        found.append(
            verdict([float(rank < 0.8) for rank in ranks], [float(rank < 0.88) for rank in ranks], criterion)[0]
        )

    assert found.count("equivalent") <= 10


def test_always_the_same_difference():
    """It is known at the first look, unless alpha is very small."""
    assert ("undecided", None) == verdict([5.0] * 29, [4.0] * 29, SMALLER)
    assert ("better", 30) == verdict([5.0] * 50, [4.0] * 50, SMALLER)
    assert ("better", 45) == verdict([5.0] * 50, [4.0] * 50, Criterion(larger_is_better=False, alpha=1e-8))


def test_equivalent_within_an_absolute_margin():
    chance = random.Random(4)
    a, b = runs(chance, DRAWS["normal"], 150)

    assert "equivalent" == verdict(a, b, Criterion(larger_is_better=True, margin=0.5))[0]
    assert "undecided" == verdict(a, b, Criterion(larger_is_better=True, margin=0.05))[0]


def test_equivalent_within_a_share_of_the_mean():
    chance = random.Random(4)
    a, b = ([100 + value for value in one] for one in runs(chance, DRAWS["normal"], 150))
    found = [
        verdict(a, b, Criterion(larger_is_better=True, margin=margin, relative=True))[0] for margin in (0.02, 5e-4)
    ]

    assert ["equivalent", "undecided"] == found


def test_equivalence_is_hardly_ever_false():
    """At most 5 % of 200 experiments of 80 pairs, with a difference as large as the margin."""
    chance = random.Random(6)
    found = []
    for _ in range(200):
        a, b = runs(chance, DRAWS["normal"], 80)
        found.append(verdict(a, [value + 0.5 for value in b], Criterion(larger_is_better=False, margin=0.5))[0])

    assert found.count("equivalent") + found.count("better") <= 10


def test_several_measures_share_alpha():
    """Each of two measures is judged at 2.5 %, so that its verdict comes later."""
    a, b = [5.0] * 80, [4.0, 3.0, 6.0, 5.0] * 20
    found = compare_all({"time": (a, b), "energy": (b, a)}, {"time": SMALLER, "energy": SMALLER}, alpha=0.05)

    assert {"time": ("better", 62), "energy": ("worse", 62)} == {
        name: (one.verdict, one.decided_after) for name, one in found.items()
    }
    assert 0.975 == found["time"].difference.confidence
    with pytest.raises(ValueError, match="measures time; criteria of energy"):
        compare_all({"time": (a, b)}, {"energy": SMALLER}, alpha=0.05)


def test_rejects_invalid_criteria():
    relative = Criterion(larger_is_better=True, margin=0.1, relative=True)
    for text, act in {
        "margin must be positive, got 0": lambda: Criterion(larger_is_better=True, margin=0),
        "alpha must be between 0 and 1, got 5": lambda: Criterion(larger_is_better=True, alpha=5),
        "the margin of yes and no is .*below 1, got 1": lambda: Criterion(larger_is_better=True, margin=1, yes_no=True),
        "a value is 2; expected 0 or 1 for yes and no": lambda: verdict([2], [1], SHARES),
        "a value of A is -1; a relative margin is for measures that are not negative": lambda: verdict(
            [-1.0], [1.0], relative
        ),
        "1 values of A and 2 of B": lambda: verdict([1.0], [1.0, 2.0], SMALLER),
        "value 0 is nan; expected numbers up to 1e": lambda: verdict([math.nan], [1.0], SMALLER),
    }.items():
        with case(text), pytest.raises(ValueError, match=text):
            act()


def test_a_verdict_that_all_pairs_together_contradict_is_withdrawn():
    pairs = [-1.0 - 0.01 * n for n in range(30)] + [1.0] * 20 + [3.0] * 120
    early, later, whole = (compare([0.0] * n, pairs[:n], SMALLER) for n in (30, 70, 170))

    assert ("better", 30, ()) == (early.verdict, early.decided_after, early.withdrawn)
    assert ("undecided", None, ("better",)) == (later.verdict, later.decided_after, later.withdrawn)
    assert ("worse", 72, ("better",)) == (whole.verdict, whole.decided_after, whole.withdrawn)
    assert 0 < whole.difference.low < whole.difference.estimate < whole.difference.high


@pytest.mark.parametrize("relative", [False, True])
def test_an_equivalence_that_all_pairs_together_contradict_is_withdrawn(relative):
    criterion = Criterion(larger_is_better=False, margin=0.05 if relative else 0.5, relative=relative)
    a, b = [10.0] * 160, [10.0] * 60 + [11.0, 13.0] * 50
    early, whole = (compare(a[:n], b[:n], criterion) for n in (60, 160))

    assert ("equivalent", 59, ()) == (early.verdict, early.decided_after, early.withdrawn)
    assert ("worse", ("equivalent",)) == (whole.verdict, whole.withdrawn)
    assert whole.decided_after > 60


P_VALUES = st.floats(0, 1)


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
    """As by R's p.adjust(p, "holm")."""
    assert tuple(adjusted) == pytest.approx(holm(given_))


@given(st.lists(P_VALUES, max_size=10))
def test_between_the_p_value_and_bonferroni(values):
    adjusted = holm(values)

    assert all(p <= one <= min(1, len(values) * p) for p, one in zip(values, adjusted, strict=True))
    assert sorted(adjusted) == [one for _, one in sorted(zip(values, adjusted, strict=True))]


def test_a_p_value_is_a_share():
    with pytest.raises(ValueError, match=r"p-value 1 is 1\.5; expected 0 to 1"):
        holm([0.1, 1.5])
