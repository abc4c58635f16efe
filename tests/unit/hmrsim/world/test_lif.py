"""Layouts in the VDMA's Layout Interchange Format."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hmrsim.errors import WorldError
from hmrsim.world import ReadOptions
from hmrsim.world_checks import load_world

DEPOT = Path(__file__).parent / "data" / "depot.lif.json"


def layout(identifier, nodes, edges=(), stations=(), **more):
    """Return a layout of nodes at (x, 0), by id, and edges between them."""
    return {
        "layoutId": identifier,
        "layoutVersion": "1",
        "nodes": [
            {"nodeId": name, "nodePosition": {"x": x, "y": 0}, "vehicleTypeNodeProperties": [{"vehicleTypeId": "v"}]}
            for name, x in nodes.items()
        ],
        "edges": [
            {
                "edgeId": f"{start}-{end}",
                "startNodeId": start,
                "endNodeId": end,
                "vehicleTypeEdgeProperties": [{"vehicleTypeId": "v", "rotationAllowed": False}],
            }
            for start, end in edges
        ],
        "stations": list(stations),
        **more,
    }


def text(*layouts, version="1.0.0"):
    """Return a file with these layouts."""
    return json.dumps({"metaInformation": {"lifVersion": version}, "layouts": layouts}, indent=1)


@pytest.fixture(scope="module")
def depot():
    """Two levels, two vehicle types, a charger and a lift."""
    return load_world(DEPOT).world


def test_nodes_are_waypoints(depot):
    """Waypoints are named by node id, and the second level is 5 m beside the first."""
    assert "depot" == depot.name
    assert {"N1": (0, 0), "N2": (5, 0), "N3": (5, 5), "N4": (14, 0), "N5": (10, 0)} == depot.waypoints


def test_edges_are_lanes(depot):
    """Edges are one-way lanes, two that match are one lane, and the limit is that of the faster vehicle type."""
    assert [
        ("N1", "N2", False, 1.5),
        ("N2", "N3", True, None),
        ("N4", "N5", True, None),
    ] == [(lane.from_, lane.to, lane.one_way, lane.speed_limit) for lane in depot.lanes]


def test_a_vehicle_type_without_a_limit_drives_as_fast_as_it_can(tmp_path):
    """The lane has no limit if one vehicle type has none."""
    whole = layout("one", {"A": 0, "B": 5}, [("A", "B")])
    whole["edges"][0]["vehicleTypeEdgeProperties"] += [{"vehicleTypeId": "slow", "maxSpeed": 0.5}]
    path = tmp_path / "one.lif.json"
    path.write_text(text(whole))

    (lane,) = load_world(path).world.lanes
    assert lane.speed_limit is None


def test_stations_are_where_vehicles_interact(depot):
    """A station with a charging node is a dock; the position of a station is only for pictures."""
    assert ({"S1": (5, 0)}, {"N3": ((5, 5), "charger")}) == (
        {name: place.at for name, place in depot.places.items()},
        {name: (dock.at, dock.type) for name, dock in depot.docks.items()},
    )


def test_an_edge_to_another_level_is_a_lift(depot):
    """Edges in both directions are one lift."""
    assert {"UP": ("N2", "N4")} == {name: lift.stops for name, lift in depot.lifts.items()}


def test_what_means_nothing_here_is_reported():
    """Each kind of ignored data is reported once, with the line of the first."""
    assert [
        (9, "theta: 1 left out"),
        (12, "actions of nodes: 1 left out"),
        (20, "maxRotationSpeed: 1 left out"),
        (20, "speed limits of slower vehicle types: 1 left out"),
        (26, "edges that no vehicle type may use: 1 left out"),
        (31, "further nodes of stations: 1 left out"),
    ] == [(warning.line, warning.message) for warning in load_world(DEPOT).warnings if warning.line]


@pytest.mark.parametrize("page", ["2", "upper"])
def test_one_layout_alone(page):
    """A single layout keeps its position, and edges to others are left out."""
    loaded = load_world(DEPOT, options=ReadOptions(page=page))

    assert {"N4": (5, 0), "N5": (1, 0)} == loaded.world.waypoints
    assert ["edges from or to other layouts: 1 left out"] == [warning.message for warning in loaded.warnings]


def test_no_such_layout():
    """The error lists the layouts."""
    with pytest.raises(WorldError, match=r"has no layout 'attic'; there are 1 \(Ground floor\), 2 \(upper\)$"):
        load_world(DEPOT, options=ReadOptions(page="attic"))


def test_layouts_of_one_level_stay_together(load):
    """Layouts of one level share their origin, and edges connect them."""
    halls = layout("a", {"A": 0}, [("A", "B")], layoutLevelId="0"), layout("b", {"B": 3}, layoutLevelId="0")
    world = load(text(*halls), "halls.lif.json").world

    assert {"A": (0, 0), "B": (3, 0)} == world.waypoints
    assert [("A", "B")] == [(lane.from_, lane.to) for lane in world.lanes]


def test_a_lift_serves_all_levels_that_are_connected(load):
    """The stops are in the order of the levels in the file."""
    levels = (
        layout("0", {"A": 0}),
        layout("1", {"B": 0}, [("B", "C"), ("B", "A")]),
        layout("2", {"C": 0}, [("C", "B")]),
    )
    world = load(text(*levels), "tower.lif.json").world

    assert {"B-C": ("A", "B", "C")} == {name: lift.stops for name, lift in world.lifts.items()}


def test_a_station_may_be_called_as_another_node(load):
    """Ids are unique within their kind only."""
    station = {"stationId": "A", "interactionNodeIds": ["B"]}
    world = load(text(layout("a", {"A": 0, "B": 3}, [("A", "B")], [station])), "a.lif.json").world

    assert ["station A"] == [*world.places]


def test_all_errors_are_reported(errors_of):
    """Duplicate and missing ids, nodes without position, dangling edges and stations without nodes are reported."""
    bad = layout("a", {"A": 0, "B": "x"}, [("A", "Z")], [{"stationId": "S", "interactionNodeIds": []}])
    twice = layout("b", {"A": 1}, (), [{"stationId": "T", "interactionNodeIds": ["A"]}] * 2)
    errors = errors_of(text(bad, twice, {"nodes": []}, version="2.0.0"), "bad.lif.json")

    assert [
        "metaInformation.lifVersion: LIF 2.0.0 is not read; expected version 1",
        "layouts.0.nodes.1.nodePosition.x: expected a number, got 'x'",
        "layouts.0.edges.0.endNodeId: no node has the id 'Z'",
        "layouts.0.stations.0.interactionNodeIds: is empty; name a node where vehicles interact",
        "layouts.1.nodes.0.nodeId: 'A' is the id of another node, too; ids are unique in a file",
        "layouts.1.stations.1.stationId: 'T' is the id of another station, too; ids are unique in a file",
        "layouts.2.layoutId: is missing",
    ] == [error.partition(": ")[2] for error in errors]
