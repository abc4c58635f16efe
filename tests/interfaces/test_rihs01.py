"""The models are ROS's own types: their hashes are those that ROS's generator makes.

``rihs01.json`` holds kilted's hashes. It has none of some packages (moveit_msgs/msg, shape_msgs and others).
A wrong field there changes the hash of the action that nests it: these are checked through Pickup and Place.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import PoseWithCovariance
from hmrsim.interfaces.message import Message
from hmrsim.interfaces.moveit_msgs import CollisionObject, Grasp, Pickup, Place
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.interfaces.sensor_msgs import BatteryState
from hmrsim.interfaces.shape_msgs import SolidPrimitive
from hmrsim.interfaces.std_msgs import Empty
from hmrsim_zenoh.ros2.rihs01 import rihs01, type_description

KILTED: dict[str, str] = json.loads((Path(__file__).parent / "rihs01.json").read_text())["kilted"]

# The table was made without these packages.
WITHOUT_HASHES = {"simulation_interfaces", "vision_msgs", "hmrsim_msgs"}


def checked_types() -> set[str]:
    """Return the types in the table and all that Pickup and Place nest."""
    actions = (Pickup.Goal, Pickup.Result, Place.Goal, Place.Result)
    nested = [one for cls in actions for one in type_description(cls)["referenced_type_descriptions"]]
    return {*KILTED, *(one["type_name"] for one in nested)}


def field_type(cls: type[Message], name: str) -> dict[str, Any]:
    """Return the description of the type of one field."""
    fields = type_description(cls)["type_description"]["fields"]
    found: dict[str, Any] = next(field["type"] for field in fields if field["name"] == name)
    return found


@pytest.mark.parametrize("ros_type", sorted(KILTED))
def test_hash_is_kilteds(ros_type: str, message_types: dict[str, type[Message]]) -> None:
    """The model of a type in the table has the hash that is in the table."""
    assert KILTED[ros_type] == rihs01(message_types[ros_type])


def test_hash_is_checked(message_type: type[Message]) -> None:
    """Every message is in the table, or is a part of one that is."""
    package = message_type.ros_type.partition("/")[0]

    assert message_type.ros_type in checked_types() or package in WITHOUT_HASHES


def test_published_hash() -> None:
    """The hash of BatteryState is the one that ``ros2 topic info -v`` shows."""
    expected = "RIHS01_4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741"

    assert expected == rihs01(BatteryState)


def test_description_of_a_flat_message() -> None:
    """A description lists the fields in order, and nests nothing where they are primitives."""
    expected = {
        "type_description": {
            "type_name": "builtin_interfaces/msg/Time",
            "fields": [
                {
                    "name": "sec",
                    "type": {"type_id": 6, "capacity": 0, "string_capacity": 0, "nested_type_name": ""},
                },
                {
                    "name": "nanosec",
                    "type": {"type_id": 7, "capacity": 0, "string_capacity": 0, "nested_type_name": ""},
                },
            ],
        },
        "referenced_type_descriptions": [],
    }

    assert expected == type_description(Time)


def test_nested_types_are_sorted_by_name() -> None:
    """What a message nests, at any depth, is described once, in the order of names."""
    nested = type_description(NavigateToPose.Goal)["referenced_type_descriptions"]

    assert [one["type_name"] for one in nested] == [
        "builtin_interfaces/msg/Time",
        "geometry_msgs/msg/Point",
        "geometry_msgs/msg/Pose",
        "geometry_msgs/msg/PoseStamped",
        "geometry_msgs/msg/Quaternion",
        "std_msgs/msg/Header",
    ]


@pytest.mark.parametrize(
    ("cls", "name", "type_id", "capacity", "nested"),
    [
        (Grasp, "id", 17, 0, ""),
        (Grasp, "max_contact_force", 10, 0, ""),
        (Grasp, "allowed_touch_objects", 17 + 144, 0, ""),
        (Grasp, "grasp_pose", 1, 0, "geometry_msgs/msg/PoseStamped"),
        (Pickup.Goal, "possible_grasps", 1 + 144, 0, "moveit_msgs/msg/Grasp"),
        (CollisionObject, "operation", 16, 0, ""),
        (PoseWithCovariance, "covariance", 11 + 48, 36, ""),
        (SolidPrimitive, "dimensions", 11 + 96, 3, ""),
    ],
)
def test_field_types(cls: type[Message], name: str, type_id: int, capacity: int, nested: str) -> None:
    """Arrays add 48 (fixed), 96 (bounded) or 144 (unbounded) to the number of their items' type."""
    expected = {"type_id": type_id, "capacity": capacity, "string_capacity": 0, "nested_type_name": nested}

    assert expected == field_type(cls, name)


def test_empty_message_has_a_padding_byte() -> None:
    """A message without fields is described with the one that ROS gives it."""
    assert field_type(Empty, "structure_needs_at_least_one_member")["type_id"] == 3


def test_field_without_ros_type_is_an_error() -> None:
    """A field that is a plain Python type is named in the error."""

    class Odd(Message):
        count: int = 0

    with pytest.raises(TypeError, match=r"Odd: field 'count': <class 'int'> has no ROS type"):
        rihs01(Odd)
