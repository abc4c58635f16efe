"""Doors and lifts over Zenoh: their services, states, and route graph."""

from __future__ import annotations

import pytest

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
