"""The simulated time that the simulator publishes."""

from __future__ import annotations

import json
import logging

import pytest

from hmrsim_zenoh.client.subscription import SimClock
from hmrsim_zenoh.wire.keys import Keys


class FakeClient:
    """A client that receives the messages of the test."""

    keys = Keys()

    def subscribe(self, key, callback, *, history):
        assert (key, history) == ("hmrsim/_world/clock", True)
        self.say = lambda payload: callback(key, payload)

    def tell(self, now):
        sec, nanosec = divmod(round(now * 1e9), 1_000_000_000)
        self.say(json.dumps({"clock": {"sec": sec, "nanosec": nanosec}}).encode())


@pytest.fixture
def client():
    return FakeClient()


def test_the_time_is_none_before_the_first_clock_message(client):
    assert SimClock(client, lambda _now: None).now is None


def test_each_time_is_passed_on(client):
    """After a reset this includes an earlier time."""
    told = []
    clock = SimClock(client, told.append)
    for now in (5.5, 6.25, 0.5):
        client.tell(now)

    assert (told, clock.now) == ([5.5, 6.25, 0.5], 0.5)


def test_a_malformed_clock_message_is_logged_and_skipped(client, caplog):
    clock = SimClock(client, lambda _now: None)
    client.tell(1.0)
    with caplog.at_level(logging.WARNING):
        client.say(b"noon")

    assert clock.now == 1.0
    assert "hmrsim/_world/clock: unreadable" in caplog.text
