"""Doors and lifts over Zenoh: their services, states, and route graph."""

from __future__ import annotations

import pytest

from tests.wire.server.conftest import to

WORLD = {
    "waypoints": {"west": [0, 0], "east": [10, 0], "upstairs": [100, 0]},
    "lanes": [["west", "east"]],
    "doors": {"gate": {"at": [[5, -1], [5, 1]]}},
    "lifts": {"lift": {"stops": ["east", "upstairs"]}},
    "robots": {"eve": {"at": "west"}},
}
OK = {"result": 1, "error_message": ""}


@pytest.fixture
def tester(serve):
    """Return a client of a world with a door and a lift, at the greatest speed."""
    return serve(WORLD, real_time_factor=0)


def ways(graph):
    """Return the edges of a route graph, by the names of their ends, with their metadata."""
    names = {
        feature["properties"]["id"]: feature["properties"]["metadata"]["name"]
        for feature in graph["features"]
        if feature["geometry"]["type"] == "Point"
    }
    edges = [feature["properties"] for feature in graph["features"] if "startid" in feature["properties"]]
    return {(names[edge["startid"]], names[edge["endid"]]): edge["metadata"] for edge in edges}


def without_stamps(bodies, *kinds):
    """Return the events of these kinds without their times."""
    return [{key: value for key, value in body.items() if key != "stamp"} for body in bodies if body["kind"] in kinds]


def test_a_robot_drives_through_a_door_and_takes_a_lift(tester):
    heard = tester.hear("_world/events")
    ended = tester.do("eve/navigate_to_pose", to(100.0, 0.0))
    bodies = heard.wait(lambda bodies: any(body["kind"] == "lift_arrived" for body in bodies))

    assert 4 == ended["status"]
    assert [
        {"kind": "door_opening", "door": "gate", "by": "eve"},
        {"kind": "door_opened", "door": "gate", "by": "eve"},
        {"kind": "lift_departed", "lift": "lift", "from": "east", "to": "upstairs", "robots": ["eve"]},
        {"kind": "lift_arrived", "lift": "lift", "stop": "upstairs", "robots": ["eve"]},
    ] == without_stamps(bodies, "door_opening", "door_opened", "lift_departed", "lift_arrived")


def test_a_locked_door_is_reported_by_the_answer_and_its_tags(tester):
    (reply,) = tester.ask("_world/set_door_state", {"name": "gate", "state": "locked"})
    info = tester.one("_world/get_entity_info", {"entity": "gate"})

    assert ({"result": OK}, "application/json;hmrsim_msgs/srv/SetDoorState_Response") == (reply.body, reply.encoding)
    assert ["door", "closed", "locked"] == info["info"]["tags"]


def test_an_unknown_door_is_an_error_in_the_response(tester):
    assert {"result": {"result": 2, "error_message": "no door 'gat'; did you mean 'gate'?"}} == tester.one(
        "_world/set_door_state", {"name": "gat", "state": "open"}
    )
    assert {"result": {"result": 2, "error_message": "no lift 'gate'; there are lift"}} == tester.one(
        "_world/call_lift", {"name": "gate", "stop": "east"}
    )


def test_the_route_graph_is_published_without_the_lane_of_a_locked_door(tester):
    heard = tester.hear("_world/route_graph")
    before = tester.one("_world/route_graph")
    for state in ("locked", "closed"):
        tester.one("_world/set_door_state", {"name": "gate", "state": state})
    graphs = heard.wait(lambda bodies: len(bodies) >= 2)

    rides = {("east", "upstairs"), ("upstairs", "east")}
    lanes = {("west", "east"), ("east", "west")}
    assert [lanes | rides, rides, lanes | rides] == [set(ways(graph)) for graph in (before, *graphs)]


def test_the_route_graph_has_rides(tester):
    """A ride has a duration and a lift, and no length."""
    ride = ways(tester.one("_world/route_graph"))["east", "upstairs"]

    assert {"length": 0.0, "lift": "lift", "ride": 9.0} == ride


def test_doors_and_lifts_are_entities_with_states(tester):
    states = tester.one("_world/get_entities_states")

    assert ["eve", "gate", "lift"] == states["entities"]
    assert [0.0, 5.0, 10.0] == [state["pose"]["position"]["x"] for state in states["states"]]
