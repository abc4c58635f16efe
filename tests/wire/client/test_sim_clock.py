"""The simulated time, as the simulator publishes it."""

from __future__ import annotations

import json
import logging

import pytest

from hmrsim_zenoh.client.subscription import SimClock
from hmrsim_zenoh.wire.keys import Keys


class FakeClient:
    """A client that receives what the test says."""

    keys = Keys()

    def subscribe(self, key, callback, *, history):
        """Keep the callback; the latest time is wanted, too."""
        assert (key, history) == ("hmrsim/_world/clock", True)
        self.say = lambda payload: callback(key, payload)

    def tell(self, now):
        """Let it be a time."""
        sec, nanosec = divmod(round(now * 1e9), 1_000_000_000)
        self.say(json.dumps({"clock": {"sec": sec, "nanosec": nanosec}}).encode())


@pytest.fixture
def client():
    """Return a client without a network."""
    return FakeClient()


def test_the_time_is_unknown_before_the_first_clock_message(client):
    """The time is None, not zero."""
    assert SimClock(client, lambda _now: None).now is None


def test_each_time_that_is_received_is_passed_on(client):
    """An earlier time is passed on, too, as after a reset."""
    told = []
    clock = SimClock(client, told.append)
    for now in (5.5, 6.25, 0.5):
        client.tell(now)

    assert (told, clock.now) == ([5.5, 6.25, 0.5], 0.5)


def test_an_unreadable_clock_is_logged_and_skipped(client, caplog):
    """Garbage on the key does not stop the subscriber."""
    clock = SimClock(client, lambda _now: None)
    client.tell(1.0)
    with caplog.at_level(logging.WARNING):
        client.say(b"noon")

    assert clock.now == 1.0
    assert "hmrsim/_world/clock: unreadable" in caplog.text
