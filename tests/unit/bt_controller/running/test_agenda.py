"""Whose time comes when."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_controller.running.timer_queue import Agenda


@pytest.fixture
def agenda():
    """Return an agenda with three times."""
    agenda = Agenda()
    for who, time in enumerate((3.0, 1.0, 2.0)):
        agenda.put(who, time)
    return agenda


def test_the_earliest_comes_first(agenda):
    """Whoever was put first."""
    assert (1.0, [1, 2], 3.0) == (agenda.earliest, agenda.take(2.5), agenda.earliest)


def test_nobody_has_a_time_at_first():
    """Never is infinitely far."""
    assert (math.inf, []) == (Agenda().earliest, Agenda().take(1e9))


def test_what_was_put_last_counts(agenda):
    """What was put off, or called off, does not come at its former time."""
    agenda.put(1, 5.0)
    agenda.put(2, math.inf)

    assert ([0], 5.0) == (agenda.take(4.0), agenda.earliest)


def test_what_was_called_off_and_put_again_comes_once(agenda):
    """Even at the very same time."""
    agenda.put(1, math.inf)
    agenda.put(1, 1.0)

    assert ([1], []) == (agenda.take(1.0), agenda.take(1.5))


def test_a_time_is_reached_to_the_nanosecond():
    """Deadlines are sums of floats."""
    agenda = Agenda()
    agenda.put(7, 0.1 + 0.2)

    assert [7] == agenda.take(0.3)


@given(st.lists(st.tuples(st.integers(0, 4), st.one_of(st.just(math.inf), st.integers(0, 9).map(float)))))
def test_it_is_as_a_table_that_is_searched(puts):
    """Only quicker."""
    agenda, table = Agenda(), {}
    for who, time in puts:
        agenda.put(who, time)
        table[who] = time
    earliest = min(table.values(), default=math.inf)
    come = sorted(who for who, time in table.items() if time <= 5.0)

    assert (earliest, come) == (agenda.earliest, sorted(agenda.take(5.0)))
