"""What takes a graph apart."""

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


def test_two_rings_and_a_lane_between_them():
    """The lane is a bottleneck, and so are its ends; places are told by side."""
    lanes = ["ab", "bc", "ca", "cd", "de", "ef", "fd"]
    places = {"desk": {"at": [0, 0]}, "shelf": {"at": [4, 0]}}
    found = bottlenecks(graph("abcdef", [list(lane) for lane in lanes], places=places))

    one, other = Side(3, ("desk",)), Side(3, ("shelf",))
    assert Bottleneck("lane", ("c", "d"), (one, other)) == found.worst[0]
    assert Bottleneck("waypoint", ("c",), (Side(3, ("shelf",)), Side(2, ("desk",)))) == found.worst[1]
    assert (2, 1, 0) == (found.waypoints, found.lanes, found.lifts)


def test_a_single_lane_has_two_sides():
    """Neither of its ends is a bottleneck."""
    found = bottlenecks(graph("ab", [["a", "b"]]))

    assert (Bottleneck("lane", ("a", "b"), (Side(1, ()), Side(1, ()))),) == found.worst


def test_a_lift_is_one_bottleneck_for_all_its_stops():
    """Its rides join each stop with each other, and it is what they have in common."""
    found = bottlenecks(graph("abc", [], lifts={"tower": {"stops": ["a", "b", "c"]}}))

    assert (Bottleneck("lift", ("tower",), (Side(1, ()), Side(1, ()), Side(1, ()))),) == found.worst


def test_what_would_be_without_a_lane():
    """A changed copy of a world's graph is asked like the graph itself."""
    ring = graph("abc", [["a", "b"], ["b", "c"], ["c", "a"]])
    changed = ring.copy()
    changed.remove_edges_from([("a", "b"), ("b", "a")])

    assert () == bottlenecks(ring).worst
    assert [("c",), ("a", "c"), ("b", "c")] == sorted(
        (one.name for one in bottlenecks(changed).worst), key=lambda name: (len(name), name)
    )


def test_empty_graphs_have_no_bottleneck():
    """Nothing, and waypoints alone."""
    assert () == bottlenecks(graph("", [])).worst == bottlenecks(graph("ab", [])).worst


@given(st.lists(st.tuples(st.integers(0, 9), st.integers(0, 9)), max_size=24))
def test_they_are_the_articulation_points_and_bridges_of_networkx(pairs):
    """And each one's sides are the parts that are there without it."""
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
