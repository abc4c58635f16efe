"""Parameters of nodes: their values, and the names that a request selects."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hmrsim.interfaces.rcl_interfaces import ParameterValue
from hmrsim.simulation.simulator import Simulator
from hmrsim.world.model import World
from hmrsim_zenoh.ros2.keys import Node
from hmrsim_zenoh.ros2.names import names_of
from hmrsim_zenoh.ros2.requests.parameter_services import names_in, parameters_of
from tests.profiles import examples

WORLD = {
    "name": "two",
    "waypoints": {"a": [0, 0], "b": [10, 0]},
    "lanes": [["a", "b"]],
    "robots": {
        "quick": {"at": "a", "base": {"speed": 2.5, "acceleration": 0.5, "turning_rate": 1.5, "radius": 0.4}},
        "plain": {"at": "b", "planner": "external"},
    },
}
CONTROLLER, DRIVER = Node("/quick", "controller_server"), Node("/quick", "base_driver")
PARTS = st.lists(st.sampled_from("abc"), min_size=1, max_size=4).map(".".join)


@pytest.fixture
def simulator():
    """Return a simulation of two robots."""
    return Simulator(World.model_validate(WORLD))


def test_values_are_those_of_the_base(simulator):
    """Speeds, accelerations and radii are those of the world's file."""
    found = parameters_of(simulator, CONTROLLER)

    names = ("max_vel_x", "max_speed_xy", "max_vel_theta", "acc_lim_x", "decel_lim_x")
    assert [2.5, 2.5, 1.5, 0.5, -0.5] == [found[f"FollowPath.{name}"].value for name in names]
    assert 0.4 == parameters_of(simulator, DRIVER)["robot_radius"].value


def test_the_speed_is_that_of_now(simulator):
    """A fault that slows a robot down changes its parameters."""
    simulator.robots["quick"].speed_scale = 0.5

    assert 1.25 == parameters_of(simulator, CONTROLLER)["FollowPath.max_vel_x"].value


def test_what_takes_no_time_has_a_number(simulator):
    """A base that turns instantly has a large finite rate; one that accelerates instantly has DWB's default."""
    found = parameters_of(simulator, Node("/plain", "controller_server"))

    assert ("1000000000.0", "0.0", "0.0") == tuple(
        str(found[f"FollowPath.{name}"].value) for name in ("max_vel_theta", "acc_lim_x", "decel_lim_x")
    )
    assert "hmrsim/external" == parameters_of(simulator, Node("/plain", "planner_server"))["GridBased.plugin"].value


def test_all_parameters_are_ros_s(simulator):
    """Each value is in the field of its type, and each parameter has a description."""
    fields = {1: "bool_value", 2: "integer_value", 3: "double_value", 4: "string_value", 9: "string_array_value"}
    for node in names_of(simulator).all_nodes.values():
        for name, parameter in parameters_of(simulator, node).items():
            value, described = parameter.as_value(), parameter.as_descriptor(name)

            assert parameter.value == getattr(value, fields[value.type])
            assert (name, value.type, True) == (described.name, described.type, described.read_only)
            assert described.description
            assert ParameterValue.NOT_SET != value.type


@examples(200)
@given(st.lists(PARTS, unique=True), st.lists(PARTS, max_size=3), st.integers(0, 4))
def test_names_by_prefix_and_depth(names, prefixes, depth):
    """Each selected name is a prefix or lies below one, by at most *depth* parts; and all such names are selected."""
    found = names_in(dict.fromkeys(names), prefixes, depth)

    def below(name, prefix):
        parts, begin = name.split("."), prefix.split(".") if prefix else []
        return parts[: len(begin)] == begin and (not depth or len(parts) - len(begin) <= depth)

    assert found == [name for name in names if any(name == one or below(name, one) for one in prefixes or [""])]
