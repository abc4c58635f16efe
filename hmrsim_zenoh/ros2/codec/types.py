"""Types of messages, services and actions in the distributions of ROS 2: names, hashes and codecs.

All types derive from our models, which are kilted's with some fields of lyrical's. A difference between a distribution
and a model is data: fields that are missing, renamed, unwrapped or added. A field that a received message lacks has our
message's default. A field that our message lacks is zero or empty when sent, and is ignored when received.

A hash or a codec is built when it is first used. Distributions with the same type share one object.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, cast

from hmrsim.interfaces.action_msgs import CancelGoal, GoalStatusArray
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.simulation_interfaces import Resource
from hmrsim_zenoh.ros2.codec.decoder import decoder
from hmrsim_zenoh.ros2.codec.encoder import encoder
from hmrsim_zenoh.ros2.codec.structures import (
    Field,
    Kind,
    Structure,
    feedback_structure,
    get_result_structures,
    send_goal_structures,
    service_structure,
    structure,
)

if TYPE_CHECKING:
    from hmrsim.actions import AnyAction
    from hmrsim.interfaces.message import Message

DISTROS: Final = ("jazzy", "kilted", "lyrical", "rolling")
"""The supported distributions, oldest first."""

OURS: Final = "kilted"
"""The distribution that our models are of, but for a few fields; the default of all functions."""


@dataclass(frozen=True)
class Difference:
    """The differences of one type to our model.

    Attributes:
        name: The type's name, if it differs.
        without: Our fields that it lacks.
        renamed: Its names of our fields.
        unwrapped: Our fields that nest a message, each with the nested field that replaces it under the outer name.
        added: Fields that our model lacks, by the field of ours that follows them; ``""`` is the end.
    """

    name: str = ""
    without: tuple[str, ...] = ()
    renamed: Mapping[str, str] = field(default_factory=dict)
    unwrapped: Mapping[str, str] = field(default_factory=dict)
    added: Mapping[str, tuple[Field, ...]] = field(default_factory=dict)


# The tracking errors of a robot that drives along lanes: it keeps to them, so zero is correct.
_TRACKING_ERRORS: Final = (Field("position_tracking_error", "float"), Field("heading_tracking_error", "float"))


def _resource(name: str, *ours: str) -> Field:
    """Return a field that nests a Resource of which our message has these fields directly."""
    fields = (one if one.name in ours else replace(one, path=None) for one in structure(Resource).fields)
    return Field(name, nested=Structure(Resource.ros_type, tuple(fields)), path=())


_CLEARINGS: Final = ("ClearEntireCostmap", "ClearCostmapExceptRegion", "ClearCostmapAroundRobot")

_NOT_BEFORE_LYRICAL: Final = {
    **{f"nav2_msgs/srv/{name}_Request": Difference(without=("plugins",)) for name in _CLEARINGS},
    **{f"nav2_msgs/srv/{name}_Response": Difference(without=("success",)) for name in _CLEARINGS},
    "nav2_msgs/srv/IsPathValid_Request": Difference(
        without=("layer_name", "footprint", "stop_at_first_collision", "max_lookahead_distance")
    ),
    "nav2_msgs/srv/IsPathValid_Response": Difference(without=("success",)),
    "nav2_msgs/action/ComputePathThroughPoses_Result": Difference(without=("last_reached_index",)),
    "nav2_msgs/action/FollowPath_Feedback": Difference(without=("tracking_feedback",)),
}

_DIFFERENCES: Final[Mapping[str, Mapping[str, Difference]]] = MappingProxyType(
    {
        "jazzy": {
            **_NOT_BEFORE_LYRICAL,
            "nav2_msgs/action/ComputePathThroughPoses_Goal": Difference(unwrapped={"goals": "goals"}),
            "nav2_msgs/action/ComputeRoute_Result": Difference(without=("error_msg",)),
            "nav2_msgs/action/ComputeAndTrackRoute_Result": Difference(without=("error_msg",)),
            "nav2_msgs/action/BackUp_Goal": Difference(without=("disable_collision_checks",)),
            "nav2_msgs/action/DriveOnHeading_Goal": Difference(without=("disable_collision_checks",)),
            "nav2_msgs/action/Spin_Goal": Difference(without=("disable_collision_checks",)),
            "nav2_msgs/action/NavigateThroughPoses_Goal": Difference(unwrapped={"poses": "goals"}),
            "nav2_msgs/action/NavigateThroughPoses_Result": Difference(without=("waypoint_statuses",)),
            "nav2_msgs/action/NavigateThroughPoses_Feedback": Difference(without=("waypoint_statuses",)),
            "nav2_msgs/srv/IsPathValid_Request": Difference(
                without=(
                    *("max_cost", "consider_unknown_as_obstacle", "layer_name", "footprint"),
                    *("stop_at_first_collision", "max_lookahead_distance"),
                )
            ),
            "nav2_msgs/msg/WaypointStatus": Difference(
                name="nav2_msgs/msg/MissedWaypoint",
                without=("waypoint_status", "error_msg"),
                renamed={"waypoint_index": "index", "waypoint_pose": "goal"},
            ),
        },
        "kilted": _NOT_BEFORE_LYRICAL,
        "lyrical": {
            "nav2_msgs/srv/ClearEntireCostmap_Request": Difference(without=("request",)),
            **{f"nav2_msgs/srv/{name}_Response": Difference(without=("response",)) for name in _CLEARINGS},
            "nav2_msgs/action/NavigateToPose_Feedback": Difference(added={"": _TRACKING_ERRORS}),
            "nav2_msgs/action/NavigateThroughPoses_Feedback": Difference(
                added={"number_of_poses_remaining": _TRACKING_ERRORS}
            ),
            # Our planner follows the route graph, and there is one path handler, so both fields are ignored.
            "nav2_msgs/action/ComputePathToPose_Goal": Difference(
                added={"planner_id": (Field("viapoints", kind=Kind.UNBOUNDED, nested=structure(PoseStamped)),)}
            ),
            "nav2_msgs/action/FollowPath_Goal": Difference(added={"": (Field("path_handler_id", "string"),)}),
            "nav2_msgs/action/FollowPath_Feedback": Difference(without=("distance_to_goal", "speed")),
            # In version 2 of simulation_interfaces one or two fields became a Resource.
            "simulation_interfaces/msg/Spawnable": Difference(
                without=("uri",), added={"description": (_resource("entity_resource", "uri"),)}
            ),
            "simulation_interfaces/srv/SpawnEntity_Request": Difference(
                without=("uri", "resource_string"),
                added={"entity_namespace": (_resource("entity_resource", "uri", "resource_string"),)},
            ),
            "simulation_interfaces/srv/LoadWorld_Request": Difference(
                without=("uri", "resource_string"),
                added={"fail_on_unsupported_element": (_resource("world_resource", "uri", "resource_string"),)},
            ),
            # The parts of the state to set. As in version 1, all parts are set.
            "simulation_interfaces/srv/SetEntityState_Request": Difference(
                added={"": tuple(Field(name, "boolean") for name in ("set_pose", "set_twist", "set_acceleration"))}
            ),
        },
    }
)


_SAME_AS: Final = {"rolling": "lyrical"}
"""Distributions whose types are all those of another one."""


@cache
def structure_in(distro: str, ours: Structure) -> Structure:
    """Return a type in a distribution: the same object if it does not differ.

    Raises:
        ValueError: No such distribution is known.
    """
    if distro not in DISTROS:
        raise ValueError(f"no distribution {distro!r}; there are {', '.join(DISTROS)}")
    if distro in _SAME_AS:
        return structure_in(_SAME_AS[distro], ours)
    difference = _DIFFERENCES[distro].get(ours.name, Difference())
    fields = tuple(_fields(distro, ours, difference))
    return ours if fields == ours.fields else Structure(difference.name or ours.name, fields)


def _fields(distro: str, ours: Structure, difference: Difference) -> Iterator[Field]:
    for one in ours.fields:
        yield from difference.added.get(one.name, ())
        if one.name in difference.without:
            continue
        has = replace(one, name=difference.renamed.get(one.name, one.name))
        if one.nested is not None:
            has = replace(has, nested=structure_in(distro, one.nested))
        yield _unwrapped(has, difference.unwrapped[one.name]) if one.name in difference.unwrapped else has
    yield from difference.added.get("", ())


def _unwrapped(outer: Field, name: str) -> Field:
    inner = () if outer.nested is None else outer.nested.fields
    held = next(field for field in inner if field.name == name)
    return replace(held, name=outer.name, path=(*(outer.path or ()), *(held.path or ())))


@dataclass(frozen=True, eq=False)
class _Type:
    structure: Structure

    @property
    def name(self) -> str:
        """The name, such as ``nav2_msgs/action/NavigateToPose_FeedbackMessage``."""
        return self.structure.name

    @cached_property
    def dds_name(self) -> str:
        """The name in keys, such as ``nav2_msgs::action::dds_::NavigateToPose_FeedbackMessage_``."""
        return dds_name(self.name)

    @cached_property
    def hash(self) -> str:
        """``RIHS01_`` and the hash in hex; a service has one hash for request and response."""
        return self.structure.hash()


class MessageType(_Type):
    """A message type in one distribution."""

    @cached_property
    def encode(self) -> Callable[[Message | Mapping[str, Any]], bytes]:
        """The function that encodes a message or its plain values; it raises `CdrError`."""
        return encoder(self.structure)

    @cached_property
    def decode(self) -> Callable[[bytes], dict[str, Any]]:
        """The function that decodes bytes to plain values, for a model to validate; it raises `CdrError`."""
        return decoder(self.structure)


@dataclass(frozen=True, eq=False)
class ServiceType(_Type):
    """A service type in one distribution."""

    request: MessageType
    response: MessageType


@dataclass(frozen=True)
class ActionType:
    """An action type in one distribution."""

    name: str
    send_goal: ServiceType
    cancel_goal: ServiceType
    get_result: ServiceType
    feedback: MessageType
    status: MessageType


def message_type(cls: type[Message], distro: str = OURS) -> MessageType:
    """Return the type of a message.

    Raises:
        ValueError: No such distribution is known.
    """
    return _message(structure_in(distro, structure(cls)))


def service_type(ros: Any, distro: str = OURS) -> ServiceType:
    """Return the type of a service, such as `SpawnEntity`, which has the messages `Request` and `Response`.

    Raises:
        ValueError: No such distribution is known.
    """
    name = ros.Request.ros_type.removesuffix("_Request")
    return _service(distro, name, structure(ros.Request), structure(ros.Response))


def service_types(ros: Any, distros: Iterable[str]) -> tuple[ServiceType, ...]:
    """Return the types of a service in some distributions.

    Raises:
        ValueError: No such distribution is known.
    """
    return tuple(service_type(ros, distro) for distro in distros)


def action_type(action: AnyAction, distro: str = OURS) -> ActionType:
    """Return the type of an action.

    Raises:
        ValueError: No such distribution is known.
    """
    name, models = action.ros_type, (action.goal, action.result, action.feedback)
    goal, result, feedback = (structure(cast("type[Message]", model)) for model in models)
    return _action(
        name,
        _service(distro, f"{name}_SendGoal", *send_goal_structures(name, goal)),
        service_type(CancelGoal, distro),
        _service(distro, f"{name}_GetResult", *get_result_structures(name, result)),
        _message(structure_in(distro, feedback_structure(name, feedback))),
        message_type(GoalStatusArray, distro),
    )


def action_types(action: AnyAction, distros: Iterable[str]) -> tuple[ActionType, ...]:
    """Return the types of an action in some distributions.

    Raises:
        ValueError: No such distribution is known.
    """
    return tuple(action_type(action, distro) for distro in distros)


def dds_name(name: str) -> str:
    """Return a type's name in keys."""
    package, kind, short = name.split("/")
    return f"{package}::{kind}::dds_::{short}_"


def _service(distro: str, name: str, request: Structure, response: Structure) -> ServiceType:
    whole, *parts = (
        structure_in(distro, one) for one in (service_structure(name, request, response), request, response)
    )
    return _one_service(whole, *map(_message, parts))


# Equal definitions share one type, for all callers and distributions.
_message = cache(MessageType)
_one_service = cache(ServiceType)
_action = cache(ActionType)
