"""Bottlenecks, reachability and traffic of the graph of a world."""

from __future__ import annotations

from importlib import import_module

import networkx as nx
import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.topology import Bottleneck, Side, bottlenecks, concentration, parts, reach, seconds_at, speeds_of, trips
from hmrsim.world import World


def graph(waypoints, lanes, **parts):
    points = {name: [number, 0] for number, name in enumerate(waypoints)}
    return World.model_validate({"waypoints": points, "lanes": lanes, **parts}).graph


def test_a_lane_between_two_rings_is_a_bottleneck_with_its_ends():
    lanes = ["ab", "bc", "ca", "cd", "de", "ef", "fd"]
    places = {"desk": {"at": [0, 0]}, "shelf": {"at": [4, 0]}}
    found = bottlenecks(graph("abcdef", [list(lane) for lane in lanes], places=places))

    one, other = Side(3, ("desk",)), Side(3, ("shelf",))
    assert Bottleneck("lane", ("c", "d"), (one, other)) == found.worst[0]
    assert Bottleneck("waypoint", ("c",), (Side(3, ("shelf",)), Side(2, ("desk",)))) == found.worst[1]
    assert (2, 1, 0) == (found.waypoints, found.lanes, found.lifts)


def test_a_single_lane_has_two_sides():
    found = bottlenecks(graph("ab", [["a", "b"]]))

    assert (Bottleneck("lane", ("a", "b"), (Side(1, ()), Side(1, ()))),) == found.worst


def test_a_lift_is_one_bottleneck_for_all_its_stops():
    found = bottlenecks(graph("abc", [], lifts={"tower": {"stops": ["a", "b", "c"]}}))

    assert (Bottleneck("lift", ("tower",), (Side(1, ()), Side(1, ()), Side(1, ()))),) == found.worst


def test_a_changed_copy_of_the_graph_can_be_analyzed():
    ring = graph("abc", [["a", "b"], ["b", "c"], ["c", "a"]])
    changed = ring.copy()
    changed.remove_edges_from([("a", "b"), ("b", "a")])

    assert () == bottlenecks(ring).worst
    assert [("c",), ("a", "c"), ("b", "c")] == sorted(
        (one.name for one in bottlenecks(changed).worst), key=lambda name: (len(name), name)
    )


def test_empty_graphs_have_no_bottleneck():
    assert () == bottlenecks(graph("", [])).worst == bottlenecks(graph("ab", [])).worst


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=24))
def test_they_are_the_articulation_points_and_bridges_of_networkx(pairs):
    names = [f"w{number}" for number in range(10)]
    lanes = [[names[a], names[b]] for a, b in pairs if a != b]
    asked = graph(names, lanes)
    plain = nx.Graph(asked)
    found = bottlenecks(asked).worst

    assert sorted(nx.articulation_points(plain)) == sorted(one.name[0] for one in found if one.kind == "waypoint")
    assert sorted(tuple(sorted(ends)) for ends in nx.bridges(plain)) == sorted(
        one.name for one in found if one.kind == "lane"
    )
    for one in found:
        without = plain.copy()
        if one.kind == "lane":
            without.remove_edge(*one.name)
            apart = [nx.node_connected_component(without, end) for end in one.name]
        else:
            beside = list(without[one.name[0]])
            without.remove_node(one.name[0])
            apart = {frozenset(nx.node_connected_component(without, name)) for name in beside}
        assert sorted(map(len, apart), reverse=True) == [side.waypoints for side in one.sides]


ONE_WAY = World.model_validate(
    {
        "waypoints": {"gate": [0, 0], "yard": [5, 0], "shed": [9, 0], "alone": [20, 0], "aside": [21, 0]},
        "lanes": [{"from": "gate", "to": "yard", "one_way": True}, ["yard", "shed"], ["alone", "aside"]],
        "places": {"entrance": {"at": [0, 1]}, "workbench": {"at": [9, 1]}, "island": {"at": [20, 1]}},
        "docks": {"plug": {"at": "yard"}},
    }
)


def test_parts_ignore_directions():
    assert [3, 2] == parts(ONE_WAY.graph)


def test_unreachable_waypoints_are_named():
    found = reach(ONE_WAY.graph)

    assert (2, 2, 1) == found.strong
    assert {
        "entrance": ("island",),
        "island": ("entrance", "plug", "workbench"),
        "plug": ("entrance", "island"),
        "workbench": ("entrance", "island"),
    } == found.gaps
    assert 8 == found.pairs


def test_a_lane_with_a_locked_door_leads_nowhere():
    door = {"at": [[5, -1], [5, 1]], "opens_for": []}
    world = {"waypoints": {"a": [0, 0], "b": [9, 0]}, "lanes": [["a", "b"]], "doors": {"vault": door}}
    graph = World.model_validate({**world, "places": {"in": {"at": [0, 0]}, "out": {"at": [9, 0]}}}).graph

    assert {"in": ("out",), "out": ("in",)} == reach(graph).gaps
    assert [2] == parts(graph)


def test_without_lanes_nothing_is_unreachable():
    for waypoints in ({}, {"a": [0, 0]}):
        graph = World.model_validate({"waypoints": waypoints, "places": {"here": {"at": [1, 1]}}}).graph

        assert ((1,) * len(waypoints), {}, 0) == tuple(vars(reach(graph)).values())


CROSS = {
    "waypoints": {"mid": [0, 0], "north": [0, 9], "east": [9, 0], "south": [0, -9], "west": [-9, 0]},
    "lanes": [["mid", end] for end in ("north", "east", "south", "west")],
}


def shares(world, speed=1.0):
    """Return the share of trips on each lane."""
    return concentration(World.model_validate(world).graph, speed).shares


def test_without_enough_places_trips_join_all_waypoints():
    assert {("east", "mid"): 0.4, ("mid", "north"): 0.4, ("mid", "south"): 0.4, ("mid", "west"): 0.4} == shares(CROSS)


def test_trips_join_places():
    docks = {f"dock_{name}": {"at": name} for name in ("north", "east", "south")}
    found = concentration(World.model_validate({**CROSS, "docks": docks}).graph, 1.0)

    third = pytest.approx(2 / 3)
    assert {("east", "mid"): third, ("mid", "north"): third, ("mid", "south"): third} == found.shares
    assert ("places", 3, 3) == (found.between, found.starts, found.of)


def test_equally_quick_routes_share_a_trip():
    square = {
        "waypoints": {"a": [0, 0], "b": [1, 0], "c": [1, 1], "d": [0, 1]},
        "lanes": [["a", "b"], ["b", "c"], ["c", "d"], ["d", "a"]],
    }

    assert [pytest.approx(1 / 3)] * 4 == list(shares(square).values())


def test_the_quickest_route_depends_on_the_speed():
    world = {
        "waypoints": {"a": [0, 0], "b": [10, 0], "c": [5, 3]},
        "lanes": [{"from": "a", "to": "b", "speed_limit": 1.0}, ["a", "c"], ["c", "b"]],
    }

    assert ("a", "b") in shares(world, 1.0)
    assert ("a", "b") not in shares(world, 2.0)


@pytest.mark.uncovered
def test_large_graphs_are_sampled(monkeypatch):
    cells = nx.grid_2d_graph(20, 20)
    world = World.model_validate(
        {
            "waypoints": {f"{x:02}_{y:02}": [x, y] for x, y in cells},
            "lanes": [[f"{a:02}_{b:02}", f"{c:02}_{d:02}"] for (a, b), (c, d) in cells.edges],
        }
    )
    whole = concentration(world.graph, 1.0)
    monkeypatch.setattr(import_module("hmrsim.topology.trips"), "MAX_STEPS", 200_000)
    found = concentration(world.graph, 1.0)

    assert (400, 131, 400) == (whole.starts, found.starts, found.of)
    assert found == concentration(world.graph, 1.0)
    assert max(abs(share - whole.shares[lane]) for lane, share in found.shares.items()) < 0.02


def test_without_lanes_there_is_no_traffic():
    assert {} == shares({}) == shares({"waypoints": {"a": [0, 0]}})


ROOMS = {
    "waypoints": {"a": [0, 0], "b": [10, 0]},
    "lanes": [{"from": "a", "to": "b", "speed_limit": 1.0, "one_way": True}],
    "places": {"desk": {"at": [0, 0]}, "shelf": {"at": [8, 0]}, "walled in": {"at": [20, 0]}},
    "docks": {"plug": {"at": "b"}},
    "walls": [[[19, -1], [21, -1], [21, 1], [19, 1], [19, -1]]],
}


def test_trips_are_possible_drives():
    """A place may be in the middle of a lane; no route leads back on a one-way lane, nor into a locked room."""
    found = trips(World.model_validate(ROOMS), 2.0)

    assert [("desk", "plug", 10.0, 10.0), ("desk", "shelf", 8.0, 8.0)] == [
        (trip.start, trip.goal, trip.length, trip.seconds) for trip in found.found if trip.start == "desk"
    ]
    assert "no route from b to a" in found.failed["plug", "desk"]
    assert ("desk", "walled in") in found.failed
    assert (4, 4) == (found.places, found.of)


def test_slower_robots_take_longer():
    world = World.model_validate(ROOMS)
    there = [trip for trip in trips(world, 2.0).found if trip.goal == "plug" and trip.start == "desk"]

    assert {("desk", "plug"): 20.0} == seconds_at(world, there, 0.5)


def test_many_places_are_sampled():
    world = World.model_validate({"places": {f"p{x:03}": {"at": [x, 0]} for x in range(150)}})
    found = trips(world, 1.0)

    assert (100, 150, 9900) == (found.places, found.of, len(found.found))
    assert found == trips(world, 1.0)


def test_the_speed_of_most_robots_comes_first():
    slow, fast, drone = ({"base": {"speed": speed, "flies": speed > 4}} for speed in (0.5, 2.0, 9.0))
    robots = {f"r{number}": {"type": kind, "at": [0, 0]} for number, kind in enumerate(["fast", "slow", "slow"])}
    types = {"slow": slow, "fast": fast, "drone": drone}
    world = {"robot_types": types, "robots": {**robots, "d": {"type": "drone", "at": [0, 0]}}}

    assert [(0.5, ("slow",)), (2.0, ("fast",))] == list(speeds_of(World.model_validate(world)).items())
    assert {300.0: ()} == speeds_of(World.model_validate({"units": "px", "robots": {}}))


def test_fewer_than_two_places_make_no_trip():
    assert () == trips(World.model_validate({}), 1.0).found
    assert () == trips(World.model_validate({"places": {"here": {"at": [0, 0]}}}), 1.0).found
