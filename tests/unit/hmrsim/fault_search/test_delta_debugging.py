"""Delta debugging finds parts that are needed, and no other."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hmrsim.fault_search.reducer import needed


def fails_with(wanted):
    """Return what tells of candidates that have all of some parts, and keeps how often it was asked."""

    def fails(candidates):
        return [wanted <= {*candidate} for candidate in candidates]

    return fails


@given(st.integers(1, 40).flatmap(lambda n: st.tuples(st.just(n), st.frozensets(st.integers(0, n - 1), max_size=6))))
def test_what_is_needed_is_found_whatever_it_is(case):
    """A failure that needs some parts is reduced to these, in their order."""
    count, wanted = case

    assert sorted(wanted) == needed(range(count), fails_with(wanted))


@given(st.lists(st.integers(0, 3), min_size=1, max_size=12))
def test_no_part_of_what_is_found_can_be_left_out(parts):
    """Also of a failure that is there with many different parts: here, that the sum is at least half of all."""
    half = sum(parts) / 2

    def fails(candidates):
        return [sum(candidate) >= half for candidate in candidates]

    found = needed(parts, fails)

    assert sum(found) >= half
    assert all(sum(found) - each < half for each in found)


def test_what_fails_by_itself_needs_nothing():
    """A failure without any part is reduced to none with one test."""
    asked = []

    def fails(candidates):
        asked.append(len(candidates))
        return [True] * len(candidates)

    assert needed("abc", fails) == []
    assert asked == [1]


def test_candidates_of_a_round_are_tested_together():
    """So that they can be run at once; of several that fail the first one is taken."""
    rounds = []

    def fails(candidates):
        rounds.append(len(candidates))
        return ["d" in candidate for candidate in candidates]

    assert needed("abcdefgh", fails) == ["d"]
    assert max(rounds) > 1
