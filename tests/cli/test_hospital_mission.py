"""The demo's mission agrees with the demo's world."""

from __future__ import annotations

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


def test_names_of_behaviours_differ(hospital):
    """What one robot does can be told apart by name."""
    for robot in hospital.robots:
        names = [node.name for node in mission(robot).iterate()]
        assert len(set(names)) == len(names)
