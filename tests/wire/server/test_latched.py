"""Latched messages, which answer plain gets and Zenoh's advanced subscribers."""

from __future__ import annotations

import json

import pytest
import zenoh
import zenoh.ext

from tests.wire.server.conftest import Heard, statuses

A = "a" * 32
WAIT = "wall_e/wait"


def test_info_describes_the_world(shared):
    (reply,) = shared.ask("_world/info")

    info = reply.body
    assert "application/json;hmrsim/WorldInfo" == reply.encoding
    assert (1, "0.1.0", "realtime", 0) == (info["contract"], info["hmrsim"], info["clock"], info["real_time_factor"])
    assert ("small", 64) == (info["world"]["name"], len(info["world"]["hash"]))
    cart = {"name": "cart", "type": "carrier", "components": [], "planner": "graph", "tags": []}
    assert {**cart, "actions": ["navigate_to_pose", "wait"]} == {
        **info["robots"][2],
        "actions": [name for name in info["robots"][2]["actions"] if name in ("navigate_to_pose", "wait", "pickup")],
    }
    assert ["claw"] == info["robots"][0]["components"]
    assert {"navigate_to_pose", "wait", "pickup", "place"} <= set(info["robots"][0]["actions"])


def test_the_route_graph_has_nav2s_format(shared):
    """It has points, and a MultiLineString for each direction of a lane."""
    (reply,) = shared.ask("_world/route_graph")

    nodes = {
        feature["properties"]["id"]: feature["properties"]["metadata"]["name"]
        for feature in reply.body["features"]
        if feature["geometry"]["type"] == "Point"
    }
    lanes = [
        (nodes[feature["properties"]["startid"]], nodes[feature["properties"]["endid"]])
        for feature in reply.body["features"]
        if feature["geometry"]["type"] == "MultiLineString"
    ]
    assert ("application/json;hmrsim/RouteGraph", "FeatureCollection") == (reply.encoding, reply.body["type"])
    assert {"home", "door", "shelf", "far", "island"} == set(nodes.values())
    assert [("home", "door"), ("door", "home"), ("door", "shelf"), ("shelf", "door")] == lanes[:4]
    assert [("far", "island"), ("island", "far")] == lanes[4:]


def test_clock_and_odometry_can_be_queried(fast, wait):
    fast.do(WAIT, wait(3))

    assert {"clock": {"sec": 3, "nanosec": 0}} == fast.one("_world/clock")
    odom = fast.one("eve/odom")
    assert ({"sec": 3, "nanosec": 0}, 9.0) == (odom["header"]["stamp"], odom["pose"]["pose"]["position"]["x"])


def test_the_status_can_be_queried_before_and_after_a_goal(fast, wait):
    before = fast.status(WAIT)
    fast.send(WAIT, wait(3), A)
    fast.result(WAIT, A)

    assert ([], [(A, 4)]) == (before, fast.status(WAIT))


@pytest.mark.parametrize(
    ("pattern", "keys"),
    [
        ("_world/*", {f"_world/{name}" for name in ("info", "route_graph", "demand", "scene", "view", "clock")}),
        ("*/odom", {"wall_e/odom", "eve/odom", "cart/odom"}),
        ("eve/wait/_action/*", {"eve/wait/_action/status"}),
        ("*/pickup/**", {"wall_e/pickup/_action/status", "eve/pickup/_action/status"}),
        ("navigate_to_pose/**", {"navigate_to_pose/wall_e/_action/status"}),
        ("w$*/wait/_action/status", {"wall_e/wait/_action/status"}),
        ("nobody/*", set()),
    ],
)
def test_a_get_with_wildcards_is_answered_once_for_each_latched_key(shared, pattern, keys):
    replies = shared.ask(pattern)

    assert sorted(f"hmrsim/{key}" for key in keys) == sorted(reply.key for reply in replies)
    assert all(reply.ok for reply in replies)


def test_a_get_of_everything_has_all_latched_messages(shared):
    keys = {reply.key for reply in shared.ask("**")}

    assert {
        "hmrsim/_world/info",
        "hmrsim/_world/clock",
        "hmrsim/cart/odom",
        "hmrsim/wall_e/grab/_action/status",
    } <= keys


@pytest.mark.parametrize("key", ["hmrsim/_world/info", "hmrsim/_world/*", "hmrsim/**"])
def test_an_advanced_subscriber_gets_the_info_as_history_by_wildcard(shared, key):
    heard = history(shared, key)

    assert heard.wait(lambda bodies: any("contract" in body for body in bodies))


def test_an_advanced_subscriber_gets_the_last_status_before_later_ones(fast, wait):
    fast.send(WAIT, wait(3), A)
    fast.result(WAIT, A)
    heard = history(fast, "hmrsim/wall_e/wait/_action/status")
    heard.wait(lambda bodies: bodies)

    fast.send(WAIT, wait(3), "b" * 32)

    bodies = heard.wait_for_status("b" * 32, 4)
    assert [(A, 4)] == statuses(bodies[0])
    assert "hmrsim/wall_e/wait/_action/status" == heard.items[0].key


def history(tester, key):
    heard = Heard()
    subscriber = zenoh.ext.declare_advanced_subscriber(
        tester.session,
        key,
        zenoh.handlers.Callback(heard.on_sample, indirect=False),
        history=zenoh.ext.HistoryConfig(max_samples=1),
    )
    heard.subscriber = subscriber  # it lives as long as what it fills
    return heard


def test_json_is_utf8_and_one_object(shared):
    (reply,) = shared.session.get("hmrsim/_world/info")

    assert {"contract", "hmrsim", "world", "clock", "real_time_factor", "robots"} <= set(
        json.loads(reply.ok.payload.to_bytes().decode("utf-8", errors="strict"))
    )


def test_info_lists_the_services_of_the_world(shared):
    (reply,) = shared.ask("_world/info")

    assert {"name": "_world/route_graph", "type": "hmrsim/RouteGraph"} in reply.body["services"]
