"""The distributions of ROS 2 that we speak, and what their types have other than ours, which are kilted's.

A difference is data: fields that are left out, have another name, are put differently, or are new.
What a distribution doesn't say when it sends has our message's default.
What it has and ours hasn't is zero or empty when we send, and is not looked at when we receive.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Final

from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.simulation_interfaces import Resource
from hmrsim.interfaces.std_msgs import Header
from hmrsim_zenoh.ros2.codec.rihs01 import Field, Kind, Structure, structure

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

DISTROS: Final = ("jazzy", "kilted", "lyrical")
"""In order of age."""

OURS: Final = "kilted"
"""The one whose types our models are."""


@dataclass(frozen=True)
class Difference:
    """What one type has other than ours.

    Attributes:
        name: The type's name, if it has another.
        without: Fields of ours that it lacks.
        renamed: Its names of fields of ours.
        unwrapped: Fields of ours that nest a message; of that, it has this field alone, under the outer name.
        added: Fields that ours lacks, by the field of ours before which they are; ``""`` is the end.
    """

    name: str = ""
    without: tuple[str, ...] = ()
    renamed: Mapping[str, str] = field(default_factory=dict)
    unwrapped: Mapping[str, str] = field(default_factory=dict)
    added: Mapping[str, tuple[Field, ...]] = field(default_factory=dict)


# How far a robot is off its path. Ours never are, so zero is the truth.
_TRACKING_ERRORS: Final = (Field("position_tracking_error", "float"), Field("heading_tracking_error", "float"))

_TRACKING_FEEDBACK: Final = Structure(
    "nav2_msgs/msg/TrackingFeedback",
    (
        Field("header", nested=structure(Header)),
        *_TRACKING_ERRORS,
        Field("current_path_index", "uint32"),
        Field("robot_pose", nested=structure(PoseStamped)),
        Field("distance_to_goal", "float", path=("distance_to_goal",)),
        Field("speed", "float", path=("speed",)),
        # Our distance is the one along the path, so it is both.
        Field("remaining_path_length", "float", path=("distance_to_goal",)),
    ),
)


def _resource(name: str, *ours: str) -> Field:
    """Return a field that nests a Resource where our message has these of the Resource's fields itself."""
    fields = (one if one.name in ours else replace(one, path=None) for one in structure(Resource).fields)
    return Field(name, nested=Structure(Resource.ros_type, tuple(fields)), path=())


_DIFFERENCES: Final[Mapping[str, Mapping[str, Difference]]] = MappingProxyType(
    {
        "jazzy": {
            "nav2_msgs/action/BackUp_Goal": Difference(without=("disable_collision_checks",)),
            "nav2_msgs/action/DriveOnHeading_Goal": Difference(without=("disable_collision_checks",)),
            "nav2_msgs/action/Spin_Goal": Difference(without=("disable_collision_checks",)),
            "nav2_msgs/action/NavigateThroughPoses_Goal": Difference(unwrapped={"poses": "goals"}),
            "nav2_msgs/action/NavigateThroughPoses_Result": Difference(without=("waypoint_statuses",)),
            "nav2_msgs/action/NavigateThroughPoses_Feedback": Difference(without=("waypoint_statuses",)),
            "nav2_msgs/msg/WaypointStatus": Difference(
                name="nav2_msgs/msg/MissedWaypoint",
                without=("waypoint_status", "error_msg"),
                renamed={"waypoint_index": "index", "waypoint_pose": "goal"},
            ),
        },
        "lyrical": {
            "nav2_msgs/action/NavigateToPose_Feedback": Difference(added={"": _TRACKING_ERRORS}),
            "nav2_msgs/action/NavigateThroughPoses_Feedback": Difference(
                added={"number_of_poses_remaining": _TRACKING_ERRORS}
            ),
            # The graph says where our planner's paths lead, and there is one path handler, so neither is used.
            "nav2_msgs/action/ComputePathToPose_Goal": Difference(
                added={"planner_id": (Field("viapoints", kind=Kind.UNBOUNDED, nested=structure(PoseStamped)),)}
            ),
            "nav2_msgs/action/FollowPath_Goal": Difference(added={"": (Field("path_handler_id", "string"),)}),
            "nav2_msgs/action/FollowPath_Feedback": Difference(
                without=("distance_to_goal", "speed"),
                added={"": (Field("tracking_feedback", nested=_TRACKING_FEEDBACK, path=()),)},
            ),
            # The second series of simulation_interfaces: what was one or two fields is a Resource.
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
            # Which parts of the state are meant. As in the first series, all are.
            "simulation_interfaces/srv/SetEntityState_Request": Difference(
                added={"": tuple(Field(name, "boolean") for name in ("set_pose", "set_twist", "set_acceleration"))}
            ),
        },
    }
)


@cache
def structure_in(distro: str, ours: Structure) -> Structure:
    """Return a type as a distribution has it: the same object if it is ours.

    Raises:
        ValueError: No such distribution is known.
    """
    if distro not in DISTROS:
        raise ValueError(f"no distribution {distro!r}; there are {', '.join(DISTROS)}")
    if distro == OURS:
        return ours
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
