"""The models of a world, and values derived from them."""

from __future__ import annotations

import pytest
from pydantic import ValidationError

from hmrsim.world.model import Derived, Lane, RobotSpec, RobotType, World


def test_lane_is_also_a_pair_of_names():
    assert Lane.model_validate(["home", "door"]) == Lane(from_="home", to="door")


@pytest.mark.parametrize("wall", [[[0, 0], [1, 0]], {"solid": [[0, 0], [1, 0], [1, 1]]}])
def test_wall_is_a_polyline_or_a_solid(wall):
    world = World.model_validate({"walls": [wall]})

    assert World.model_validate(world.model_dump(mode="json")).walls == world.walls


@pytest.mark.parametrize("fields", [{"seed": "7"}, {"bounds": [0, 0, 1, float("inf")]}, {"size": 1}])
def test_wrong_field_is_rejected(fields):
    with pytest.raises(ValidationError, match="1 validation error"):
        World.model_validate(fields)


def test_fault_keeps_its_own_fields():
    world = World.model_validate({"faults": [{"type": "lane_closed", "at": 30}]})

    assert world.faults[0].model_extra == {"at": 30}


def test_fault_with_infinity_is_rejected():
    with pytest.raises(ValidationError, match="until must be a finite number"):
        World.model_validate({"faults": [{"type": "x", "until": [float("inf")]}]})


def test_robot_overrides_its_type():
    kind = {"base": {"speed": 1.0, "radius": 0.2}, "components": {"claw": {"reach": 1.0}, "battery": {}}}
    robot = {"type": "t", "at": [0, 0], "base": {"speed": 2.0}, "components": {"battery": None}}
    world = World.model_validate({"robot_types": {"t": kind}, "robots": {"r": robot}})

    assert world.robot_type(world.robots["r"]) == RobotType.model_validate(
        {"base": {"speed": 2.0, "radius": 0.2}, "components": {"claw": {"reach": 1.0}}}
    )


def test_point_of_a_name():
    world = World.model_validate({"waypoints": {"a": [1, 2]}, "docks": {"c": {"at": [3, 4]}}})

    assert [world.point("a"), world.point("c"), world.point((5.0, 6.0))] == [(1, 2), (3, 4), (5, 6)]


def test_robot_without_a_speed_drives_as_the_unit_says():
    base = RobotSpec(at=(0.0, 0.0)).base

    assert [World(units="m").speed(base), World(units="px").speed(base)] == [1.0, 300.0]


BODY = {"base": {"radius": 0.3}}
BODIES = {"ann": {"at": [0, 0], **BODY}, "bob": {"at": [5, 0], **BODY}}


def policy(**fields):
    return World.model_validate(fields).policy


WIDE = {name: {"at": robot["at"], "type": "wide"} for name, robot in BODIES.items()}


@pytest.mark.parametrize("robots", [BODIES, WIDE], ids=["robots", "types"])
def test_two_robots_with_radii_keep_apart_by_default(robots):
    assert "planned" == policy(robots=robots, robot_types={"wide": BODY})


@pytest.mark.parametrize(
    "bob",
    [
        {"at": [5, 0]},
        {"at": [5, 0], "base": {"radius": 0.3, "flies": True}},
        {"at": [5, 0], "type": "wide", "base": {"radius": None}},
        {"at": [5, 0], "type": "unknown"},
    ],
    ids=["a point", "a flying robot", "a point of a type with a radius", "an unknown type"],
)
def test_robots_pass_through_each_other_if_fewer_than_two_have_radii(bob):
    assert "free" == policy(robots={**BODIES, "bob": bob}, robot_types={"wide": BODY})


def test_traffic_settings_do_not_choose_a_policy():
    assert ["planned", "free"] == [policy(robots=robots, traffic={"patience": 30}) for robots in (BODIES, {})]


def test_the_policy_of_the_file_is_in_force():
    assert "free" == policy(robots=BODIES, traffic={"policy": "free"})


def world(name):
    return World(name=name, waypoints={"a": (0.0, 0.0)})


def test_a_derived_value_is_computed_once_for_each_world():
    asked = []
    derived = Derived(lambda world: asked.append(world.name) or len(asked))
    one, other = world("one"), world("one")

    assert [1, 1, 2, 1] == [derived(each) for each in (one, one, other, one)]


def test_a_derived_value_is_forgotten_with_its_world(collect):
    """The address of a world may be reused."""
    derived = Derived(lambda world: world.name)
    names = []
    for number in range(50):
        names.append(derived(world(str(number))))
        collect()

    assert [str(number) for number in range(50)] == names
    assert {} == derived._known


def test_a_copy_with_the_same_parts_keeps_a_derived_value(collect):
    asked = []
    derived = Derived(lambda world: asked.append(world.name) or [*world.waypoints], "waypoints")
    first = world("first")
    copy, other = first.model_copy(update={"name": "copy"}), first.model_copy(update={"waypoints": {"b": (1.0, 0.0)}})
    values = [derived(each) for each in (first, copy, other)]

    assert ([["a"], ["a"], ["b"]], ["first", "first"]) == (values, asked)
    del first
    collect()
    assert (["a"], ["first", "first", "copy"]) == (derived(copy), asked)


def test_a_value_that_a_copy_with_faults_needs_first_outlives_the_copy(collect):
    asked = []
    derived = Derived(lambda world: asked.append(len(world.faults)), "waypoints")
    base, faults = world("base"), World.model_validate({"faults": [{"type": "lane_closed", "at": 30}]}).faults
    for _ in range(3):
        derived(base.with_faults(faults).with_faults(faults))
        collect()

    assert [2] == asked
    del base
    collect()
    assert {} == derived._known
