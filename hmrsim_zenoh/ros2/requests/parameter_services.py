"""The parameters of ROS nodes, with Nav2's names where Nav2 has them, and the services that read them.

Clients can't set parameters: their values come from the world's file and the simulator's options.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, NamedTuple, TypeVar

from hmrsim.interfaces.rcl_interfaces import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    ListParametersResult,
    ParameterDescriptor,
    ParameterValue,
    SetParameters,
    SetParametersAtomically,
    SetParametersResult,
)
from hmrsim_zenoh.ros2.names import FURTHER_NAMES, MAP_SERVER, NODES, OTHER_NODE

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message
    from hmrsim.robots.robot import Robot
    from hmrsim.simulation.simulator import Simulator
    from hmrsim_zenoh.ros2.keys import Node

    Value = bool | int | float | str | list[str]

_T = TypeVar("_T")

_DOT: Final = "."
_UNLIMITED: Final = 1e9
"""The value for an unlimited turning rate, as clients expect a finite number."""
_TYPES: Final[Mapping[type, tuple[int, str]]] = MappingProxyType(
    {
        bool: (ParameterValue.BOOL, "bool_value"),
        int: (ParameterValue.INTEGER, "integer_value"),
        float: (ParameterValue.DOUBLE, "double_value"),
        str: (ParameterValue.STRING, "string_value"),
        list: (ParameterValue.STRING_ARRAY, "string_array_value"),
    }
)
"""The number of each type of parameter in ROS, and the field of its value."""


class NodeParameter(NamedTuple):
    """A parameter, which clients can't set."""

    value: Value
    description: str

    @property
    def type(self) -> int:
        """The number of its type in ROS."""
        return _TYPES[type(self.value)][0]

    def as_value(self) -> ParameterValue:
        """Return the value as a ROS message."""
        number, field = _TYPES[type(self.value)]
        return ParameterValue.model_validate({"type": number, field: self.value})

    def as_descriptor(self, name: str) -> ParameterDescriptor:
        """Return the description as a ROS message."""
        return ParameterDescriptor(name=name, type=self.type, description=self.description, read_only=True)


def parameters_of(simulator: Simulator, node: Node) -> dict[str, NodeParameter]:
    """Return the parameters of a node by name, in order of name."""
    parameters = {
        "start_type_description_service": NodeParameter(True, "Whether get_type_description is there."),
        "use_sim_time": NodeParameter(True, "Stamps are simulated time."),
    }
    robot = simulator.robots.get(node.robot)
    if node == MAP_SERVER:
        parameters["frame_id"] = NodeParameter("map", "The frame of the map.")
        parameters["topic_name"] = NodeParameter("map", "The topic of the map.")
    elif robot is None:
        parameters["world"] = NodeParameter(simulator.world.name, "The name of the world.")
        parameters["seed"] = NodeParameter(simulator.seed, "The seed of the run.")
    else:
        parameters |= _of_robot(robot, node.name, f"{simulator.world.units}")
    return dict(sorted(parameters.items()))


def names_in(parameters: Mapping[str, NodeParameter], prefixes: Sequence[str], depth: int) -> list[str]:
    """Return the names that a request selects, as rclcpp does.

    Args:
        parameters: All parameters.
        prefixes: The whole parts that names must begin with; empty for all names.
        depth: The largest number of parts beyond a prefix; 0 for any.
    """

    def near(rest: str) -> bool:
        return not depth or rest.count(_DOT) < depth

    def within(name: str, prefix: str) -> bool:
        return name == prefix or (name.startswith(prefix + _DOT) and near(name[len(prefix) + 1 :]))

    return [name for name in parameters if (any(within(name, one) for one in prefixes) if prefixes else near(name))]


def _of_robot(robot: Robot, node: str, units: str) -> dict[str, NodeParameter]:
    frames = {
        "global_frame": NodeParameter("map", "The frame of poses."),
        "robot_base_frame": NodeParameter("base_link", "The robot's frame."),
    }
    speed = NodeParameter(robot.speed, f"The greatest speed now, in {units}/s.")
    turning = NodeParameter(robot.base.turning_rate or _UNLIMITED, "The turning rate in rad/s; 1e9 turns at once.")
    # 0 is DWB's default. An unlimited deceleration is 0.0, too, not -0.0, which tools would print.
    acceleration = robot.base.acceleration or 0.0
    change = NodeParameter(acceleration, f"In {units}/s²; 0 is no limit: speed changes at once.")
    of_nodes: dict[str, dict[str, NodeParameter]] = {
        "amcl": {
            "global_frame_id": frames["global_frame"],
            "base_frame_id": NodeParameter("base_footprint", "The robot's frame on the ground."),
        },
        "bt_navigator": {
            **frames,
            "odom_topic": NodeParameter("odom", "The topic of odometry."),
            "navigators": NodeParameter(list(NODES["bt_navigator"]), "The actions of this node."),
        },
        "planner_server": {
            "planner_plugins": NodeParameter(["GridBased"], "The valid planner_id; it may be omitted."),
            "GridBased.plugin": NodeParameter(f"hmrsim/{robot.planner}", "graph: the world's lanes; or external."),
        },
        "route_server": {
            "route_frame": frames["global_frame"],
            "base_frame": frames["robot_base_frame"],
        },
        "smoother_server": {
            "smoother_plugins": NodeParameter(
                ["simple_smoother", "route_smoother"], "The valid smoother_id; it may be omitted."
            ),
        },
        "controller_server": {
            "odom_topic": NodeParameter("odom", "The topic of odometry."),
            "controller_plugins": NodeParameter(["FollowPath"], "The valid controller_id; it may be omitted."),
            "FollowPath.plugin": NodeParameter("hmrsim", "Exact motion from pose to pose."),
            "FollowPath.max_vel_x": speed,
            "FollowPath.max_speed_xy": speed,
            "FollowPath.max_vel_theta": turning,
            "FollowPath.acc_lim_x": change,
            "FollowPath.decel_lim_x": change._replace(value=-acceleration or 0.0),
        },
        "behavior_server": {
            **frames,
            "behavior_plugins": NodeParameter(
                [FURTHER_NAMES.get(action, (action,))[0] for action in NODES["behavior_server"]],
                "The actions of this node.",
            ),
            "max_rotational_vel": turning,
        },
        "waypoint_follower": {
            "stop_on_failure": NodeParameter(False, "Whether a missed waypoint ends the goal."),
        },
        "docking_server": {
            "base_frame": frames["robot_base_frame"],
            "fixed_frame": frames["global_frame"],
            "docks": NodeParameter(sorted(robot.docks), "The docks of the world."),
        },
        OTHER_NODE: {
            "robot_type": NodeParameter(robot.type, "The type of the robot."),
            "robot_radius": NodeParameter(robot.radius, f"The radius of the footprint in {units}; 0 for none."),
            "components": NodeParameter(list(robot.components), "The components of the robot."),
            "flies": NodeParameter(robot.flies, "Whether the robot leaves the lanes."),
        },
    }
    return of_nodes.get(node, {})


def get_parameters(simulator: Simulator, node: Node, request: Mapping[str, Any]) -> Message:
    """Return the values of the requested parameters."""
    return GetParameters.Response(values=_map(simulator, node, request, lambda _name, one: one.as_value()))


def get_parameter_types(simulator: Simulator, node: Node, request: Mapping[str, Any]) -> Message:
    """Return the types of the requested parameters."""
    return GetParameterTypes.Response(types=_map(simulator, node, request, lambda _name, one: one.type))


def describe_parameters(simulator: Simulator, node: Node, request: Mapping[str, Any]) -> Message:
    """Return the descriptions of the requested parameters."""
    descriptors = _map(simulator, node, request, lambda name, one: one.as_descriptor(name))
    return DescribeParameters.Response(descriptors=descriptors)


def list_parameters(simulator: Simulator, node: Node, request: Mapping[str, Any]) -> Message:
    """Return the names that a request selects."""
    names = names_in(parameters_of(simulator, node), request["prefixes"], request["depth"])
    prefixes = list(dict.fromkeys(name.rpartition(".")[0] for name in names if "." in name))
    return ListParameters.Response(result=ListParametersResult(names=names, prefixes=prefixes))


def set_parameters(simulator: Simulator, node: Node, request: Mapping[str, Any]) -> Message:
    """Return for each parameter why it can't be set."""
    return SetParameters.Response(results=_not_set(simulator, node, request))


def set_parameters_atomically(simulator: Simulator, node: Node, request: Mapping[str, Any]) -> Message:
    """Return why the first parameter can't be set."""
    results = _not_set(simulator, node, request) or [SetParametersResult(successful=True)]
    return SetParametersAtomically.Response(result=results[0])


RESPONSES: Final = MappingProxyType(
    {
        "get_parameters": get_parameters,
        "get_parameter_types": get_parameter_types,
        "describe_parameters": describe_parameters,
        "list_parameters": list_parameters,
        "set_parameters": set_parameters,
        "set_parameters_atomically": set_parameters_atomically,
    }
)
"""The function that responds to each parameter service."""


def _map(
    simulator: Simulator, node: Node, request: Mapping[str, Any], convert: Callable[[str, NodeParameter], _T]
) -> list[_T]:
    """Convert each requested parameter; return an empty list if one does not exist, as rclcpp does."""
    parameters, names = parameters_of(simulator, node), request["names"]
    return [convert(name, parameters[name]) for name in names] if parameters.keys() >= set(names) else []


def _not_set(simulator: Simulator, node: Node, request: Mapping[str, Any]) -> list[SetParametersResult]:
    """Return for each parameter of a request why it can't be set."""
    parameters = parameters_of(simulator, node)
    reasons = {
        True: "is read-only: it comes from the world's file or the simulator's options",
        False: "does not exist",
    }
    return [
        SetParametersResult(reason=f"parameter {name!r} {reasons[name in parameters]}")
        for name in (one["name"] for one in request["parameters"])
    ]
