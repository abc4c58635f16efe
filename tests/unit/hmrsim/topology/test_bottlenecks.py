"""Bottlenecks, whose removal disconnects a graph."""

from __future__ import annotations

import networkx as nx
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.topology import Bottleneck, Side, bottlenecks
from hmrsim.world import World


def graph(waypoints, lanes, **parts):
    """Return the graph of a world whose waypoints are in a row."""
    points = {name: [number, 0] for number, name in enumerate(waypoints)}
    return World.model_validate({"waypoints": points, "lanes": lanes, **parts}).graph


def test_a_lane_between_two_rings_is_a_bottleneck_with_its_ends():
    """Places are listed by side."""
    lanes = ["ab", "bc", "ca", "cd", "de", "ef", "fd"]
    places = {"desk": {"at": [0, 0]}, "shelf": {"at": [4, 0]}}
    found = bottlenecks(graph("abcdef", [list(lane) for lane in lanes], places=places))

    one, other = Side(3, ("desk",)), Side(3, ("shelf",))
    assert Bottleneck("lane", ("c", "d"), (one, other)) == found.worst[0]
    assert Bottleneck("waypoint", ("c",), (Side(3, ("shelf",)), Side(2, ("desk",)))) == found.worst[1]
    assert (2, 1, 0) == (found.waypoints, found.lanes, found.lifts)


def test_the_ends_of_a_single_lane_are_no_bottlenecks():
    found = bottlenecks(graph("ab", [["a", "b"]]))

    assert (Bottleneck("lane", ("a", "b"), (Side(1, ()), Side(1, ()))),) == found.worst


def test_a_lift_is_one_bottleneck_for_all_its_stops():
    found = bottlenecks(graph("abc", [], lifts={"tower": {"stops": ["a", "b", "c"]}}))

    assert (Bottleneck("lift", ("tower",), (Side(1, ()), Side(1, ()), Side(1, ()))),) == found.worst


def test_a_changed_copy_of_a_graph_can_be_queried():
    ring = graph("abc", [["a", "b"], ["b", "c"], ["c", "a"]])
    changed = ring.copy()
    changed.remove_edges_from([("a", "b"), ("b", "a")])

    assert () == bottlenecks(ring).worst
    assert [("c",), ("a", "c"), ("b", "c")] == sorted(
        (one.name for one in bottlenecks(changed).worst), key=lambda name: (len(name), name)
    )


def test_a_graph_without_lanes_has_no_bottleneck():
    assert () == bottlenecks(graph("", [])).worst == bottlenecks(graph("ab", [])).worst


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=24))
def test_bottlenecks_are_the_articulation_points_and_bridges_of_networkx(pairs):
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
