"""The demo's mission agrees with the demo's world."""

from __future__ import annotations

from itertools import combinations

import pytest

from bt_controller.hospital import PLACES, mission
from hmrsim.world import load_world


@pytest.fixture(scope="module")
def hospital():
    """Return the hospital."""
    return load_world("hospital").world


def test_places_are_where_the_map_has_them(hospital):
    """The controller knows the places of the house as the map has them."""
    assert dict(PLACES) == {name: hospital.places[name].at for name in PLACES}


def test_every_robot_has_a_mission(hospital):
    """Each robot of the map has a tree, named after it."""
    names = [mission(robot).name for robot in hospital.robots]

    assert [f"Mission of {robot}" for robot in hospital.robots] == names


def test_eight_robots_of_seven_types(hospital):
    """The fleet is heterogeneous: no two types have the same base."""
    bases = [kind.base for kind in hospital.robot_types.values()]

    assert (8, 7) == (len(hospital.robots), len({robot.type for robot in hospital.robots.values()}))
    assert all(a != b for a, b in combinations(bases, 2))


def test_nobody_has_the_errand_of_another(hospital):
    """Each robot of the map goes its own way."""
    errands = {tuple(node.name for node in mission(robot).children) for robot in hospital.robots}

    assert len(hospital.robots) == len(errands)


def test_what_is_fetched_can_be_carried(hospital):
    """Items of the missions are in the house, and not too heavy for whom they are given to."""
    fetched = {
        node.name.removeprefix("Fetch "): hospital.robot_type(spec).components["claw"]["max_weight"]
        for robot, spec in hospital.robots.items()
        for node in mission(robot).iterate()
        if node.name.startswith("Fetch ")
    }

    assert ["blood_samples", "defibrillator", "linen", "meal", "medicine"] == sorted(fetched)
    assert all(hospital.items[item].weight <= most for item, most in fetched.items())


def test_nobody_works_by_a_script(hospital):
    """A script would give a robot goals of its own beside those of the mission."""
    assert all(robot.script == () for robot in hospital.robots.values())


def test_names_of_behaviours_differ(hospital):
    """What one robot does can be told apart by name."""
    for robot in hospital.robots:
        names = [node.name for node in mission(robot).iterate()]
        assert len(set(names)) == len(names)
