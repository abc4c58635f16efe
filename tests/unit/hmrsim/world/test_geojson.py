"""Route graphs of Nav2, read and written."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world import World
from hmrsim.world.formats.geojson import FORMAT
from hmrsim.world.route_graph import to_geojson
from hmrsim.world_checks import load_world
from tests.paths import REFERENCES, nav2_files
from tests.profiles import examples

HERE = Path(__file__).parent
REFERENCE = REFERENCES / "nav2"

HOME = {"type": "Feature", "properties": {"id": 1}, "geometry": {"type": "Point", "coordinates": [0.0, 0.0]}}
SHELF = {"type": "Feature", "properties": {"id": 2}, "geometry": {"type": "Point", "coordinates": [3.0, 4.0]}}


def edge(start, end, **metadata):
    properties = {"id": 9, "startid": start, "endid": end, "metadata": metadata}
    return {"type": "Feature", "properties": properties, "geometry": {"type": "MultiLineString"}}


def text(*features):
    return '{"type": "FeatureCollection", "features": [\n' + ",\n".join(map(json.dumps, features)) + "\n]}\n"


@pytest.fixture(scope="module")
def crossing():
    return load_world(HERE / "data" / "crossing.geojson")


def test_nodes_are_waypoints_and_edges_lanes(crossing):
    lanes = [(lane.from_, lane.to, lane.one_way, lane.speed_limit) for lane in crossing.world.lanes]

    assert {"home": (0, 0), "node_2": (4, 0), "node_3": (4, 3)} == crossing.world.waypoints
    assert [("home", "node_2", False, 0.5), ("node_2", "node_3", True, 0.85)] == lanes


def test_an_edge_is_straight_whatever_its_line(crossing):
    """Nav2 also uses only the ends of an edge."""
    assert 4.0 == WaypointGraph(crossing.world).plan((0.0, 0.0), (4.0, 0.0), 1.0).length


def test_ignored_data_is_reported_once(crossing):
    assert [
        (6, "costs other than the length: 1 left out"),
        (7, "further metadata: 1 left out"),
        (8, "operations: 1 left out"),
        (12, "speed limits in percent: 1 taken of 1 m/s"),
        (14, "ids of nodes that do not count from 0: 3 given anew"),
        (16, "frames other than map: 1 left out"),
        (17, "another node is called 'home', too; this one is called 'node_3'"),
        (19, "features that are neither nodes nor edges: 1 left out"),
    ] == [(warning.line, warning.message) for warning in crossing.warnings]


@pytest.mark.parametrize(
    ("metadata", "limit"),
    [
        ({"abs_speed_limit": 0.3}, 0.3),
        ({"abs_speed_limit": 0.3, "speed_limit": 50}, 0.3),
        ({"abs_speed_limit": 0.0}, None),
        ({"speed_limit": 85}, 0.85),
        ({"speed_limit": 0.85}, 0.85),
        ({"speed_limit": 100}, None),
        ({"speed_limit": 1}, None),
        ({"speed_limit": 0}, None),
        ({}, None),
    ],
)
def test_speed_limits_are_as_nav2_takes_them(load, metadata, limit):
    (lane,) = load(text(HOME, SHELF, edge(1, 2, **metadata)), "g.geojson").world.lanes

    assert limit == lane.speed_limit


def test_the_faster_of_two_edges_counts(load):
    features = [edge(1, 2, abs_speed_limit=0.5), edge(1, 2, abs_speed_limit=0.8), edge(1, 2, abs_speed_limit=0.1)]
    (lane,) = load(text(HOME, SHELF, *features), "g.geojson").world.lanes

    assert 0.8 == lane.speed_limit


def test_given_names_precede_generated_ones(load):
    named = {**HOME, "properties": {"id": 5, "metadata": {"name": "node_2"}}}

    assert ["node_2_", "node_2"] == list(load(text(SHELF, named), "g.geojson").world.waypoints)


def test_all_errors_are_reported_with_their_lines(errors_of):
    nowhere = {"type": "Feature", "properties": {"id": 4}, "geometry": {"type": "Point", "coordinates": [1]}}
    nameless = {"type": "Feature", "properties": {}, "geometry": {"type": "Point", "coordinates": [1, 2]}}
    edges = [edge(1, 7), edge("a", 1), edge(1, None), edge(2, 1, abs_speed_limit="x")]
    bad = [HOME, HOME, SHELF, nowhere, nameless, *edges, 5]

    assert [
        "3: features.1.properties.id: 1 is the id of another node, too; ids are unique",
        "5: features.3.geometry.coordinates: expected [x, y], got [1]",
        "6: features.4.properties.id: is missing",
        "7: features.5.properties.endid: no node has the id 7",
        "8: features.6.properties.startid: expected a number, got 'a'",
        "9: features.7.properties.endid: is missing",
        "10: features.8.properties.metadata.abs_speed_limit: expected a number, got 'x'",
        "11: features.9: expected a mapping, got 5",
    ] == errors_of(text(*bad), "g.geojson")


def test_a_coordinate_out_of_range_has_its_line(errors_of):
    far = {**SHELF, "geometry": {"type": "Point", "coordinates": [3e8, 0]}}

    assert ["3: waypoints.node_2.0: must be at most 1e+07, got 300000000.0"] == errors_of(text(HOME, far), "g.geojson")


def test_an_edge_to_its_own_start_is_left_out(load):
    loaded = load(text(HOME, SHELF, edge(1, 1), edge(1, 2), edge(2, 2)), "g.geojson")

    assert [("node_1", "node_2")] == [(lane.from_, lane.to) for lane in loaded.world.lanes]
    assert [
        (2, "ids of nodes that do not count from 0: 2 given anew"),
        (4, "leads from 'node_1' to itself; left out, as no robot could drive it"),
        (6, "leads from 'node_2' to itself; left out, as no robot could drive it"),
    ] == [(warning.line, warning.message) for warning in loaded.warnings]


@pytest.mark.skipif(not REFERENCE.is_dir(), reason="Nav2's graph is not here")
def test_nav2_s_sample_graph_loads():
    loaded = load_world(REFERENCE / "turtlebot3_graph.geojson")

    assert (20, 32) == (len(loaded.world.waypoints), len(loaded.world.lanes))
    assert {"ids of nodes that do not count from 0: 20 given anew", "ways that were there before: 1 left out"} == {
        warning.message for warning in loaded.warnings
    }


@pytest.mark.parametrize("graph", nav2_files(".geojson"), ids=lambda path: path.name)
def test_every_graph_of_nav2_loads(graph):
    assert load_world(graph).world.waypoints


def test_a_native_file_can_include_a_graph(write, load):
    write(text(HOME, SHELF, edge(1, 2)), "floor.geojson")
    world = load("include: [floor.geojson]\nrobots: {eve: {at: node_2}}\n").world

    assert (3.0, 4.0) == world.point(world.robots["eve"].at)


def test_nav2_gets_limits_as_floats():
    world = World.model_validate(
        {"waypoints": {"a": [0, 0], "b": [3, 4]}, "lanes": [{"from": "a", "to": "b", "speed_limit": 2}]}
    )

    assert '"cost": 5.0, "metadata": {"length": 5.0, "abs_speed_limit": 2.0}' in json.dumps(to_geojson(world))


@pytest.mark.parametrize(("closed", "ends", "number"), [(("b", "a"), (0, 1), 2), (("a", "b"), (1, 0), 3)])
def test_closed_lanes_are_not_written(closed, ends, number):
    world = World.model_validate({"waypoints": {"a": [0, 0], "b": [3, 4]}, "lanes": [["a", "b"]]})
    (way,) = to_geojson(world, closed={closed})["features"][2:]

    assert (*ends, number) == tuple(way["properties"][key] for key in ("startid", "endid", "id"))


names = st.text(st.characters(codec="utf-8", exclude_categories=["Cs"]), min_size=1, max_size=12)
coordinates = st.floats(-1e7, 1e7)
capacities = st.none() | st.integers(1, 9)


@st.composite
def graphs(draw):
    points = draw(st.dictionaries(names, st.tuples(coordinates, coordinates), min_size=2, max_size=6))
    waypoints = {
        name: at if (capacity := draw(capacities)) is None else {"at": at, "capacity": capacity}
        for name, at in points.items()
    }
    pairs = draw(st.lists(st.tuples(st.sampled_from([*points]), st.sampled_from([*points])), unique_by=frozenset))
    lanes = []
    for start, end in pairs:
        limits = st.none() | st.floats(1e-3, 1e9)
        one_way = draw(st.booleans())
        ends = [(start, end), (end, start)] if one_way and draw(st.booleans()) else [(start, end)]
        lanes += [
            {"from": a, "to": b, "one_way": one_way, "speed_limit": draw(limits), "capacity": draw(capacities)}
            for a, b in ends
            if a != b
        ]
    return World.model_validate({"name": draw(names), "waypoints": waypoints, "lanes": lanes})


@given(graphs())
@examples(200)
def test_a_graph_written_and_read_is_the_same(world):
    data = FORMAT.read(json.dumps(to_geojson(world)), "g.geojson").data
    again = World.model_validate(data)

    assert (world.name, world.waypoints, world.lanes) == (again.name, again.waypoints, again.lanes)
    assert [*world.waypoints] == [*again.waypoints]
