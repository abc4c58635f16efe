"""The order of the timers of several trees."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from bt_controller.running.schedule import TimerQueue


@pytest.fixture
def timers():
    """Return an timers with three times."""
    timers = TimerQueue()
    for who, time in enumerate((3.0, 1.0, 2.0)):
        timers.put(who, time)
    return timers


def test_the_earliest_comes_first(timers):
    """The order of insertion does not matter."""
    assert (1.0, [1, 2], 3.0) == (timers.earliest, timers.pop_due(2.5), timers.earliest)


def test_an_empty_queue_has_no_time():
    """Its earliest time is infinity."""
    assert (math.inf, []) == (TimerQueue().earliest, TimerQueue().pop_due(1e9))


def test_what_was_put_last_counts(timers):
    """A time that was replaced or removed is not due."""
    timers.put(1, 5.0)
    timers.put(2, math.inf)

    assert ([0], 5.0) == (timers.pop_due(4.0), timers.earliest)


def test_what_was_called_off_and_put_again_comes_once(timers):
    """Even at the very same time."""
    timers.put(1, math.inf)
    timers.put(1, 1.0)

    assert ([1], []) == (timers.pop_due(1.0), timers.pop_due(1.5))


def test_a_time_is_reached_to_the_nanosecond():
    """Deadlines are sums of floats."""
    timers = TimerQueue()
    timers.put(7, 0.1 + 0.2)

    assert [7] == timers.pop_due(0.3)


@given(st.lists(st.tuples(st.integers(0, 4), st.one_of(st.just(math.inf), st.integers(0, 9).map(float)))))
def test_it_is_as_a_table_that_is_searched(puts):
    """A search in a table gives the same results."""
    timers, table = TimerQueue(), {}
    for who, time in puts:
        timers.put(who, time)
        table[who] = time
    earliest = min(table.values(), default=math.inf)
    come = sorted(who for who, time in table.items() if time <= 5.0)

    assert (earliest, come) == (timers.earliest, sorted(timers.pop_due(5.0)))
