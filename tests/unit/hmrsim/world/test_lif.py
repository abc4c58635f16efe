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
    return json.dumps({"metaInformation": {"lifVersion": version}, "layouts": layouts}, indent=1)


@pytest.fixture(scope="module")
def depot():
    return load_world(DEPOT).world


def test_nodes_edges_stations_and_levels_are_read(depot):
    """A station with a charging node is a dock, and an edge to another level is a lift."""
    assert "depot" == depot.name
    assert {"N1": (0, 0), "N2": (5, 0), "N3": (5, 5), "N4": (14, 0), "N5": (10, 0)} == depot.waypoints
    lanes = [(lane.from_, lane.to, lane.one_way, lane.speed_limit) for lane in depot.lanes]
    assert [("N1", "N2", False, 1.5), ("N2", "N3", True, None), ("N4", "N5", True, None)] == lanes
    assert {"S1": (5, 0)} == {name: place.at for name, place in depot.places.items()}
    assert {"N3": ((5, 5), "charger")} == {name: (dock.at, dock.type) for name, dock in depot.docks.items()}
    assert {"UP": ("N2", "N4")} == {name: lift.stops for name, lift in depot.lifts.items()}


def test_a_vehicle_type_without_a_limit_drives_as_fast_as_it_can(tmp_path):
    whole = layout("one", {"A": 0, "B": 5}, [("A", "B")])
    whole["edges"][0]["vehicleTypeEdgeProperties"] += [{"vehicleTypeId": "slow", "maxSpeed": 0.5}]
    path = tmp_path / "one.lif.json"
    path.write_text(text(whole))

    (lane,) = load_world(path).world.lanes
    assert lane.speed_limit is None


def test_ignored_data_is_reported_once():
    assert [
        (9, "theta: 1 left out"),
        (12, "actions of nodes: 1 left out"),
        (20, "maxRotationSpeed: 1 left out"),
        (20, "speed limits of slower vehicle types: 1 left out"),
        (26, "edges that no vehicle type may use: 1 left out"),
        (31, "further nodes of stations: 1 left out"),
    ] == [(warning.line, warning.message) for warning in load_world(DEPOT).warnings if warning.line]


@pytest.mark.parametrize("page", ["2", "upper"])
def test_a_single_layout_keeps_its_position(page):
    loaded = load_world(DEPOT, options=ReadOptions(page=page))

    assert {"N4": (5, 0), "N5": (1, 0)} == loaded.world.waypoints
    assert ["edges from or to other layouts: 1 left out"] == [warning.message for warning in loaded.warnings]


def test_an_unknown_layout_lists_the_layouts():
    with pytest.raises(WorldError, match=r"has no layout 'attic'; there are 1 \(Ground floor\), 2 \(upper\)$"):
        load_world(DEPOT, options=ReadOptions(page="attic"))


def test_layouts_of_one_level_stay_together(load):
    halls = layout("a", {"A": 0}, [("A", "B")], layoutLevelId="0"), layout("b", {"B": 3}, layoutLevelId="0")
    world = load(text(*halls), "halls.lif.json").world

    assert {"A": (0, 0), "B": (3, 0)} == world.waypoints
    assert [("A", "B")] == [(lane.from_, lane.to) for lane in world.lanes]


def test_a_lift_serves_all_levels_that_are_connected(load):
    levels = (
        layout("0", {"A": 0}),
        layout("1", {"B": 0}, [("B", "C"), ("B", "A")]),
        layout("2", {"C": 0}, [("C", "B")]),
    )
    world = load(text(*levels), "tower.lif.json").world

    assert {"B-C": ("A", "B", "C")} == {name: lift.stops for name, lift in world.lifts.items()}


def test_ids_are_unique_within_their_kind(load):
    station = {"stationId": "A", "interactionNodeIds": ["B"]}
    world = load(text(layout("a", {"A": 0, "B": 3}, [("A", "B")], [station])), "a.lif.json").world

    assert ["station A"] == [*world.places]


def test_all_errors_are_reported(errors_of):
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
