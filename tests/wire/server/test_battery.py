"""Batteries and docks, as an outside client sees them."""

from __future__ import annotations

import pytest

SUCCEEDED, ABORTED = 4, 6
CHARGING = 1

WORLD = {
    "name": "energy",
    "waypoints": {"home": [0, 0], "shelf": [20, 0]},
    "lanes": [["home", "shelf"]],
    "docks": {"charger": {"at": [0, 5], "type": "charger", "power": 2}},
    "robots": {
        "eve": {"at": "home", "components": {"battery": {"capacity": 100, "initial_charge": 30}}},
        "cart": {"at": "shelf"},
    },
}


@pytest.fixture
def tester(serve):
    """Return a client of a world with a robot that lasts half a minute, and one without a battery."""
    return serve(WORLD, real_time_factor=0)


def test_the_latest_battery_state_can_be_got(tester, wait):
    tester.do("eve/wait", wait(10))
    (reply,) = tester.ask("eve/battery_state")

    assert "application/json;sensor_msgs/msg/BatteryState" == reply.encoding
    assert 0.2 == pytest.approx(reply.body["percentage"])
    assert ("eve", True, 7) == (reply.body["serial_number"], reply.body["present"], len(reply.body["cell_voltage"]))


def test_reading_a_missing_battery_is_an_error(tester):
    (reply,) = tester.ask("cart/battery_state")

    assert (False, "cart has no battery") == (reply.ok, reply.body["error"])


def test_a_query_for_all_batteries_skips_robots_without_one(tester):
    replies = tester.ask("*/battery_state")

    assert [(True, "hmrsim/eve/battery_state")] == [(reply.ok, reply.key) for reply in replies]


def test_a_subscriber_gets_a_message_each_second_and_at_each_event(tester, wait):
    """The battery is low at 10 s, and critical at 25 s."""
    heard = tester.hear("eve/battery_state")
    events = tester.hear("_world/events")
    tester.do("eve/wait", wait(26))
    events.wait(lambda bodies: any(body["kind"] == "battery_critical" for body in bodies))
    bodies = heard.wait(lambda bodies: any(body["percentage"] <= 0.05 for body in bodies))

    assert {"battery_low", "battery_critical"} <= {body["kind"] for body in events.bodies}
    assert any(body["percentage"] == pytest.approx(0.2) and body["header"]["stamp"]["sec"] == 10 for body in bodies)
