"""The models of a world."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from hmrsim.world.model import Lane, RobotSpec, RobotType, World


def test_lane_is_also_a_pair_of_names():
    """``[home, door]`` is the lane from home to door, both ways."""
    assert Lane.model_validate(["home", "door"]) == Lane(from_="home", to="door")


@pytest.mark.parametrize("wall", [[[0, 0], [1, 0]], {"solid": [[0, 0], [1, 0], [1, 1]]}])
def test_wall_is_a_polyline_or_a_solid(wall):
    """A wall comes back as it was written."""
    world = World.model_validate({"walls": [wall]})

    assert World.model_validate(world.model_dump(mode="json")).walls == world.walls


@pytest.mark.parametrize("fields", [{"seed": "7"}, {"bounds": [0, 0, 1, float("inf")]}, {"size": 1}])
def test_wrong_field_is_refused(fields):
    """Text is not a number, infinity is no coordinate, and an unknown key is no key."""
    with pytest.raises(ValidationError, match="1 validation error"):
        World.model_validate(fields)


def test_fault_keeps_its_own_fields():
    """What a fault needs is its own."""
    world = World.model_validate({"faults": [{"type": "lane_closed", "at": 30}]})

    assert world.faults[0].model_extra == {"at": 30}


def test_fault_with_infinity_is_refused():
    """Own fields must be finite, too."""
    with pytest.raises(ValidationError, match="until must be a finite number"):
        World.model_validate({"faults": [{"type": "x", "until": [float("inf")]}]})


def test_robot_overrides_its_type():
    """A robot's own settings go over those of its type; null takes a component away."""
    kind = {"base": {"speed": 1.0, "radius": 0.2}, "components": {"claw": {"reach": 1.0}, "battery": {}}}
    robot = {"type": "t", "at": [0, 0], "base": {"speed": 2.0}, "components": {"battery": None}}
    world = World.model_validate({"robot_types": {"t": kind}, "robots": {"r": robot}})

    assert world.robot_type(world.robots["r"]) == RobotType.model_validate(
        {"base": {"speed": 2.0, "radius": 0.2}, "components": {"claw": {"reach": 1.0}}}
    )


def test_point_of_a_name():
    """A waypoint, place or dock stands for its point."""
    world = World.model_validate({"waypoints": {"a": [1, 2]}, "docks": {"c": {"at": [3, 4]}}})

    assert [world.point("a"), world.point("c"), world.point((5.0, 6.0))] == [(1, 2), (3, 4), (5, 6)]


def test_robot_without_a_speed_drives_as_the_unit_says():
    """1 m/s, or 300 px/s."""
    base = RobotSpec(at=(0.0, 0.0)).base

    assert [World(units="m").speed(base), World(units="px").speed(base)] == [1.0, 300.0]
