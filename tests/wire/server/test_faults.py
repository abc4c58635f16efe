"""Faults and sensors over Zenoh."""

from __future__ import annotations

import pytest
import zenoh

from tests.simulation import SMALL_WORLD
from tests.wire.server.conftest import Heard

GOAL = "a" * 32
OK = {"result": 1, "error_message": ""}
LOST = "no connection to wall_e; it is lost for a while"


@pytest.fixture
def lost(live):
    """Return a client of the small world in which wall_e can't be reached."""
    assert OK == live.one("_world/inject_fault", {"type": "messages_lost", "robot": "wall_e"})["result"]
    return live


def test_a_fault_is_injected_and_cleared_by_its_name(live):
    events = live.hear("_world/events")
    injected = live.one("_world/inject_fault", {"type": "lane_closed", "lane": ["home", "door"]})
    known = live.one("_world/get_faults")["faults"]
    ways = [one for one in live.one("_world/route_graph")["features"] if one["geometry"]["type"] != "Point"]
    cleared = live.one("_world/clear_fault", {"name": "lane_closed_1"})
    told = events.wait(lambda bodies: any(body["kind"] == "fault_ended" for body in bodies))

    assert {"result": OK, "name": "lane_closed_1"} == injected
    assert [("lane_closed_1", "lane_closed", True)] == [(one["name"], one["type"], one["active"]) for one in known]
    assert 4 == len(ways)
    assert {"result": OK, "names": ["lane_closed_1"]} == cleared
    began = next(body for body in told if body["kind"] == "fault_began")
    assert ("lane_closed", "lane_closed_1", ["home", "door"]) == (began["fault"], began["name"], began["lane"])


@pytest.mark.parametrize("key", ["wall_e/odom", "wall_e/wait/_action/status"])
def test_reading_an_unreachable_robot_is_an_error(lost, key):
    (reply,) = lost.ask(key)

    assert (False, LOST) == (reply.ok, reply.body["error"])


def test_the_token_is_gone_while_the_robot_is_unreachable(live):
    heard = Heard()
    handler = zenoh.handlers.Callback(heard.on_sample, indirect=False)
    key = live.key("wall_e/alive")
    live._subscribers.append(live.session.liveliness().declare_subscriber(key, handler, history=True))
    live.one("_world/inject_fault", {"type": "messages_lost", "robot": "wall_e"})
    heard.wait(lambda bodies: len(bodies) == 2)
    live.one("_world/clear_fault")
    heard.wait(lambda bodies: len(bodies) == 3)

    assert [True, False, True] == [item.ok for item in heard.items]


WATCHED = {
    **SMALL_WORLD,
    "robots": {**SMALL_WORLD["robots"], "wall_e": {"at": "home", "yaw": 0.0, "components": {"camera": {}}}},
    "remap": {},
}


def test_detections_are_latched_in_order_of_name(serve):
    (reply,) = serve(WATCHED).ask("wall_e/detections")

    assert "application/json;vision_msgs/msg/Detection3DArray" == reply.encoding
    assert ["anvil", "cart", "eve", "parcel"] == [one["id"] for one in reply.body["detections"]]
