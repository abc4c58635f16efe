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
    """A wall is written as it was read."""
    world = World.model_validate({"walls": [wall]})

    assert World.model_validate(world.model_dump(mode="json")).walls == world.walls


@pytest.mark.parametrize("fields", [{"seed": "7"}, {"bounds": [0, 0, 1, float("inf")]}, {"size": 1}])
def test_wrong_field_is_rejected(fields):
    """Text is not a number, infinity is no coordinate, and unknown keys are errors."""
    with pytest.raises(ValidationError, match="1 validation error"):
        World.model_validate(fields)


def test_fault_keeps_its_own_fields():
    """The fields of a fault depend on its type."""
    world = World.model_validate({"faults": [{"type": "lane_closed", "at": 30}]})

    assert world.faults[0].model_extra == {"at": 30}


def test_fault_with_infinity_is_rejected():
    """The fields of a fault must be finite."""
    with pytest.raises(ValidationError, match="until must be a finite number"):
        World.model_validate({"faults": [{"type": "x", "until": [float("inf")]}]})


def test_robot_overrides_its_type():
    """A robot's settings override those of its type, and null removes a component."""
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
    """The default speed is 1 m/s, or 300 px/s."""
    base = RobotSpec(at=(0.0, 0.0)).base

    assert [World(units="m").speed(base), World(units="px").speed(base)] == [1.0, 300.0]


BODY = {"base": {"radius": 0.3}}
BODIES = {"ann": {"at": [0, 0], **BODY}, "bob": {"at": [5, 0], **BODY}}


def policy(**fields):
    """Return the traffic policy in force in a world with these fields."""
    return World.model_validate(fields).policy


def test_two_robots_with_bodies_keep_apart_by_default():
    """Both robots have a radius."""
    assert "planned" == policy(robots=BODIES)


def test_a_body_may_come_from_the_type():
    """The radius of a robot type holds for each robot of the type."""
    robots = {"ann": {"at": [0, 0], "type": "wide"}, "bob": {"at": [5, 0], "type": "wide"}}

    assert "planned" == policy(robots=robots, robot_types={"wide": BODY})


@pytest.mark.parametrize(
    "bob",
    [
        {"at": [5, 0]},
        {"at": [5, 0], "base": {"radius": 0.3, "flies": True}},
        {"at": [5, 0], "type": "wide", "base": {"radius": None}},
    ],
    ids=["a point", "one that flies", "a point of a type with a radius"],
)
def test_robots_pass_through_each_other_if_fewer_than_two_have_bodies(bob):
    """A single robot with a radius can't touch another."""
    assert "free" == policy(robots={**BODIES, "bob": bob}, robot_types={"wide": BODY})


def test_settings_of_traffic_do_not_choose_a_policy():
    """`patience` without a policy leaves the choice to the robots."""
    assert ["planned", "free"] == [policy(robots=robots, traffic={"patience": 30}) for robots in (BODIES, {})]


def test_the_policy_of_the_file_is_in_force():
    """A file can choose any policy, whatever its robots are."""
    assert "free" == policy(robots=BODIES, traffic={"policy": "free"})


def test_a_robot_of_an_unknown_type_has_no_body():
    """The unknown type is reported separately."""
    assert "free" == policy(robots={**BODIES, "bob": {"at": [5, 0], "type": "wide"}})
