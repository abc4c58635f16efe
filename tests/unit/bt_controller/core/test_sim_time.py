"""Simulated time for the timers of py_trees."""

from __future__ import annotations

import time

from hypothesis import given
from hypothesis import strategies as st
from py_trees import decorators, timers
from py_trees.behaviours import Running
from py_trees.common import Status
from py_trees.decorators import Timeout
from py_trees.timers import Timer

from bt_controller.core.sim_time import simulated_time, time_behind

TIMES = st.integers(0, 10**15).map(lambda nanoseconds: nanoseconds / 1e9)


def status_at(now, behaviour):
    """Tick a behavior at a time, and return its status."""
    with simulated_time(now):
        behaviour.tick_once()
    return behaviour.status


@given(begin=TIMES, duration=st.integers(10_000, 10**13).map(lambda nanoseconds: nanoseconds / 1e9))
def test_a_timer_ends_at_its_time(begin, duration):
    timer, end = Timer("Timer", duration), begin + duration
    statuses = [status_at(now, timer) for now in (begin, end - 1e-6, end)]

    assert [Status.RUNNING, Status.RUNNING, Status.SUCCESS] == statuses


def test_a_timeout_fails_at_its_time():
    timeout = Timeout("Timeout", Running("Running"), 5.0)

    assert [Status.RUNNING, Status.RUNNING, Status.FAILURE] == [status_at(now, timeout) for now in (10.0, 14.999, 15.0)]


def test_py_trees_has_its_own_time_back_afterwards():
    """Other trees of the process may live by the wall's clock."""
    with simulated_time(3.0):
        assert (timers.time.time(), decorators.time.monotonic()) == (3.0, 3.0)
        assert timers.time.sleep is time.sleep

    assert (timers.time, decorators.time) == (time, time)


def test_without_a_clock_there_is_no_simulated_time():
    with simulated_time(None):
        assert timers.time is time


@given(
    begin=st.floats(60.0, 120.0),
    stood=st.floats(0.0, 60.0),
    duration=st.integers(10_000, 10**10).map(lambda nanoseconds: nanoseconds / 1e9),
)
def test_a_timer_after_a_standstill_ends_at_the_instant_that_it_names(begin, stood, duration):
    """The simulator's times have fractions of nanoseconds, while its clock is asked for whole ones."""
    timer = Timer("Timer", duration)
    with simulated_time(begin), time_behind(round(stood, 9)):
        timer.tick_once()
    named = round((timer.finish_time + round(stood, 9)) * 1e9) / 1e9
    with simulated_time(named), time_behind(round(stood, 9)):
        timer.tick_once()

    assert Status.SUCCESS == timer.status
