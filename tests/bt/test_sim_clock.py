"""The clock that counts periods of simulated time."""

from __future__ import annotations

import logging

import pytest

from bt_controller.sim_clock import SimClock


@pytest.fixture
def periods(client):
    """Return the times at which a clock of 2 s called back, and the clock."""
    called = []
    clock = SimClock(client, 2.0, lambda: called.append(clock.now))
    return called, clock


def test_nobody_knows_the_time_before_the_clock_was_heard(periods):
    """None is not zero."""
    assert periods[1].now is None


def test_periods_count_from_the_first_time_that_is_heard(client, periods):
    """A controller that comes late has the same rhythm."""
    for now in (5.5, 6.5, 7.4, 7.5, 8.0, 9.5):
        client.clock(now)

    assert periods[0] == [7.5, 9.5]


def test_a_clock_that_leaps_calls_once(client, periods):
    """What was missed is not made up for; the rhythm stays."""
    for now in (0.0, 7.0, 7.9, 8.0):
        client.clock(now)

    assert periods[0] == [7.0, 8.0]


def test_periods_begin_anew_when_time_goes_back(client, periods):
    """After a reset nobody waits for the old time to come again."""
    for now in (100.0, 0.5, 2.4, 2.5):
        client.clock(now)

    assert periods[0] == [2.5]


def test_an_unreadable_clock_is_logged_and_skipped(client, periods, caplog):
    """Garbage on the key does not stop the controller."""
    client.clock(1.0)
    with caplog.at_level(logging.WARNING):
        client.publish("hmrsim/_world/clock", b"noon")

    assert periods[1].now == 1.0
    assert "hmrsim/_world/clock: unreadable" in caplog.text
