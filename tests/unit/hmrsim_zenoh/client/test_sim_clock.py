"""The simulated time that the simulator publishes, and what rings and wakes by it."""

from __future__ import annotations

import logging

from hmrsim_zenoh.client.subscription import SimClock


def test_the_time_is_none_before_the_first_clock_message(client):
    assert SimClock(client, lambda _now: None).now is None


def test_each_time_is_passed_on(connection, client):
    """After a reset this includes an earlier time."""
    told = []
    clock = SimClock(client, told.append)
    for now in (5.5, 6.25, 0.5):
        connection.clock(now)

    assert (told, clock.now) == ([5.5, 6.25, 0.5], 0.5)


def test_a_malformed_clock_message_is_logged_and_skipped(connection, client, caplog):
    clock = SimClock(client, lambda _now: None)
    connection.clock(1.0)
    with caplog.at_level(logging.WARNING):
        connection.publish("hmrsim/_world/clock", b"noon")

    assert clock.now == 1.0
    assert "hmrsim/_world/clock: unreadable" in caplog.text


def test_an_alarm_rings_after_its_time(connection, client):
    rung = []
    connection.clock(5.0)
    client.alarm(2.0, lambda: rung.append(connection.latest))
    connection.clock(6.9)
    before = len(rung)
    connection.clock(7.0)

    assert (0, 1) == (before, len(rung))


def test_a_closed_alarm_does_not_ring(connection, client):
    rung = []
    client.alarm(2.0, lambda: rung.append(True)).close()
    connection.clock(9.0)

    assert [] == rung
