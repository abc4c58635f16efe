"""Topics of robots as trees read them, from a real simulator."""

from __future__ import annotations

import json
from functools import partial
from threading import Event

import pytest

from bt_controller.core.robots import NotServed, Topics
from hmrsim_zenoh.client.client import Client
from tests.patience import PATIENCE
from tests.served_world import served_world

NAMES = [f"r{number}" for number in range(20)]
WORLD = {
    "name": "yard",
    "waypoints": {f"at_{name}": [float(number), 0.0] for number, name in enumerate(NAMES)},
    "robot_types": {"cart": {"components": {"battery": {"capacity": 100}}}},
    "robots": {name: {"type": "cart", "at": f"at_{name}"} for name in NAMES},
}


@pytest.fixture
def lockstep():
    """Return a client that takes part in lockstep."""
    with served_world(WORLD, clock="lockstep") as options, Client(options) as client:
        yield client


@pytest.fixture
def asked(lockstep, monkeypatch):
    """Return the list of the keys that are queried."""
    keys = []

    def noted(ask, key, *arguments):
        keys.append(key)
        return ask(key, *arguments)

    for name in ("get", "get_all"):
        monkeypatch.setattr(lockstep, name, partial(noted, getattr(lockstep, name)))
    return keys


def test_a_topic_is_queried_once_per_instant(lockstep, asked):
    """All leaves share the reply."""
    topics = Topics(lockstep, asks=True)
    topics.watch("r3", "odom")
    lockstep.sleep(1.0)
    asked.clear()
    first, second = topics.latest("r3", "odom"), topics.latest("r3", "odom")

    assert (3.0, True) == (first.pose.pose.position.x, first is second)
    assert ["hmrsim/r3/odom"] == asked


def test_a_topic_is_queried_again_when_time_has_passed(lockstep):
    topics = Topics(lockstep, asks=True)
    topics.watch("r3", "battery_state")
    before = topics.latest("r3", "battery_state").percentage
    lockstep.sleep(10.0)

    assert (1.0, 0.9) == (before, pytest.approx(topics.latest("r3", "battery_state").percentage))


def test_a_topic_is_queried_again_after_a_change(lockstep, asked):
    topics = Topics(lockstep, asks=True)
    topics.watch("r3", "odom")
    topics.latest("r3", "odom")
    asked.clear()
    topics.forget()
    topics.latest("r3", "odom")

    assert ["hmrsim/r3/odom"] == asked


def test_a_disconnected_robot_keeps_its_last_known_battery_state(lockstep):
    topics = Topics(lockstep, asks=True)
    topics.watch("r3", "battery_state")
    fault = {"type": "messages_lost", "robot": "r3", "duration": 60}
    lockstep.get(lockstep.keys.world("inject_fault"), payload=json.dumps(fault).encode())
    lockstep.sleep(10.0)

    assert 1.0 == topics.latest("r3", "battery_state").percentage


def test_many_robots_are_asked_at_once(lockstep, asked):
    """A few robots are queried one by one, and many with one request per instant."""
    topics = Topics(lockstep, asks=True)
    for name in NAMES:
        topics.watch(name, "odom")
    asked.clear()
    seen = []
    for _ in range(2):
        lockstep.sleep(1.0)
        seen += [topics.latest(name, "odom").pose.pose.position.x for name in NAMES]

    assert [float(number) for number in range(20)] * 2 == seen
    assert [*(f"hmrsim/r{number}/odom" for number in range(4)), "hmrsim/*/odom"] * 2 == asked


def test_a_topic_that_the_robot_does_not_publish_fails_the_setup():
    with (
        served_world(clock="lockstep") as options,
        Client(options) as client,
        pytest.raises(NotServed, match="battery"),
    ):
        Topics(client, asks=True).watch("wall_e", "battery_state")


def test_each_message_wakes_the_watcher_in_real_time():
    woken = Event()
    with served_world(WORLD, real_time_factor=100.0) as options, Client(options) as client:
        topics = Topics(client, asks=False)
        topics.watch("r3", "battery_state", woken.set)
        before = topics.latest("r3", "battery_state").percentage
        # A message may have come before that already.
        while (now := topics.latest("r3", "battery_state").percentage) == before:
            woken.clear()
            assert woken.wait(PATIENCE)
        topics.close()

    assert now < before <= 1.0
