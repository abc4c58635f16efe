"""Checks that the mission of the demo fits its world."""

from __future__ import annotations

import pytest

from bt_controller.behaviours.robot_actions import GoTo
from bt_controller.examples.hospital import mission
from hmrsim.navigation.graph import WaypointGraph
from hmrsim.world_checks import load_world


@pytest.fixture(scope="module")
def hospital():
    return load_world("hospital").world


def test_missions_use_known_places(hospital):
    visited = {node.name for robot in hospital.robots for node in mission(robot).iterate() if isinstance(node, GoTo)}

    assert 13 == len(visited)
    assert visited <= {f"Go to {place}" for place in hospital.places}


def test_the_pharmacy_opens_for_robots_with_a_mission_there(hospital):
    visitors = [name for name in hospital.robots if any(n.name == "Go to pharmacy" for n in mission(name).iterate())]

    assert ("nurse", "courier") == hospital.doors["pharmacy"].opens_for
    assert ["wall_e"] == visitors
    assert "nurse" == hospital.robots["wall_e"].type


def test_a_route_leads_around_the_visitors(hospital):
    (closed,) = (fault.model_extra["lane"] for fault in hospital.faults if fault.type == "lane_closed")
    graph = WaypointGraph(hospital)
    graph.closed = frozenset([tuple(closed), tuple(reversed(closed))])
    places = {name: place.at for name, place in hospital.places.items()}
    lanes = [leg.lane for leg in graph.plan(places["kitchen"], places["ward_d"], 1.0).legs]

    assert ("ward_a_aisle", "ward_b_aisle") in lanes
    assert all(graph.plan(places["kitchen"], point, 1.0).legs for name, point in places.items() if name != "kitchen")


def test_fetched_items_can_be_carried(hospital):
    fetched = {
        node.name.removeprefix("Fetch "): hospital.robot_type(spec).components["claw"]["max_weight"]
        for robot, spec in hospital.robots.items()
        for node in mission(robot).iterate()
        if node.name.startswith("Fetch ")
    }

    assert ["blood_samples", "defibrillator", "linen", "meal", "medicine"] == sorted(fetched)
    assert all(hospital.items[item].weight <= most for item, most in fetched.items())


def test_no_robot_has_a_script(hospital):
    """A script would send goals in addition to those of the mission."""
    assert all(robot.script == () for robot in hospital.robots.values())


def test_names_of_behaviors_differ(hospital):
    """The demo tells behaviors of a robot apart by their names."""
    for robot in hospital.robots:
        names = [node.name for node in mission(robot).iterate()]
        assert len(set(names)) == len(names)
