"""The models have the hashes of ROS's own types, in each distribution.

``rihs01.json`` holds the hashes by the distributions that have them, also of the types that ROS derives.
It has none of some packages (moveit_msgs/msg, shape_msgs and others).
A wrong field there changes the hash of the action that nests it: these are checked through Pickup and Place.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import PoseWithCovariance
from hmrsim.interfaces.moveit_msgs import CollisionObject, Grasp, Pickup, Place
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.interfaces.shape_msgs import SolidPrimitive
from hmrsim.interfaces.std_msgs import Empty
from hmrsim_zenoh.ros2.codec.structures import structure
from hmrsim_zenoh.ros2.codec.types import DISTROS
from tests.ros_types import messages, structures

if TYPE_CHECKING:
    from hmrsim.interfaces.message import Message

TABLE: dict[str, dict[str, str]] = json.loads((Path(__file__).parent / "rihs01.json").read_text())
HASHES = {
    (distro, ros_type): expected
    for distros, hashes in TABLE.items()
    for distro in distros.split()
    for ros_type, expected in hashes.items()
}

SEEN = [
    ("kilted", "sensor_msgs/msg/BatteryState", "4bee5dfce981c98faa6828b868307a0a73f992ed0789f374ee96c8f840e69741"),
    ("kilted", "tf2_msgs/msg/TFMessage", "e369d0f05a23ae52508854b66f6aa0437f3449d652e8cbf22d5abe85d020f087"),
    ("kilted", "vision_msgs/msg/Detection3DArray", "793f5eab9595ac1c0da07873cc859db42eae51f0ee76056db8562515d830e018"),
    ("lyrical", "rcl_interfaces/srv/GetParameters", "bf9803d5c74cf989a5de3e0c2e99444599a627c7ff75f97b8c05b01003675cbc"),
    (
        "lyrical",
        "rcl_interfaces/srv/GetParameterTypes",
        "da199c878688b3e530bdfe3ca8f74cb9fa0c303101e980a9e8f260e25e1c80ca",
    ),
    ("lyrical", "rcl_interfaces/srv/SetParameters", "56eed9a67e169f9cb6c1f987bc88f868c14a8fc9f743a263bc734c154015d7e0"),
    (
        "lyrical",
        "rcl_interfaces/srv/SetParametersAtomically",
        "0e192ef259c07fc3c07a13191d27002222e65e00ccec653ca05e856f79285fcd",
    ),
    (
        "lyrical",
        "rcl_interfaces/srv/ListParameters",
        "3e6062bfbb27bfb8730d4cef2558221f51a11646d78e7bb30a1e83afac3aad9d",
    ),
    (
        "lyrical",
        "rcl_interfaces/srv/DescribeParameters",
        "845b484d71eb0673dae682f2e3ba3c4851a65a3dcfb97bddd82c5b57e91e4cff",
    ),
    (
        "kilted",
        "simulation_interfaces/srv/GetEntities",
        "cb90004c48cd50f37732fb008e22c34c261dd680a723bf0f85d8437ea4498bf7",
    ),
    (
        "kilted",
        "simulation_interfaces/srv/GetEntitiesStates",
        "0a76170d0c1c90e1eaf805cfab78ea801d1f82df309a28c1f0fae4b570f19754",
    ),
    (
        "kilted",
        "simulation_interfaces/srv/GetNamedPoses",
        "c3d12ab920115bfd4733f6d20516adc3968fb438538540997c37e200e02b04e3",
    ),
    (
        "kilted",
        "simulation_interfaces/srv/GetAvailableWorlds",
        "ce5589b5523f2732d1969a3c5a7e6b17a387091df8190c62f78d7fdd1109e3e3",
    ),
    (
        "kilted",
        "simulation_interfaces/srv/ResetSimulation",
        "4ce285d7ff9b8ac70dcc95161f32bf54c05a6f4b13427990e41ab40c36c39646",
    ),
    (
        "kilted",
        "simulation_interfaces/srv/StepSimulation",
        "913fe0653690ce6bf8f09f316e6a626747012e9fca31e26719910d417aa8565c",
    ),
    (
        "lyrical",
        "simulation_interfaces/srv/SpawnEntity",
        "66860313e11009faddbfc8568e5d410d1a11607fe75eeb1308671dc0406fe3a7",
    ),
    (
        "lyrical",
        "simulation_interfaces/srv/LoadWorld",
        "87d0ded1bfddb40a74d0bedb963fdd592fbedb14d0057d597850404b73c338af",
    ),
    (
        "kilted",
        "type_description_interfaces/srv/GetTypeDescription",
        "69b9c19c1021405984cc60dbbb1edceb147a6538b411d812ba6afabeed962cd5",
    ),
    (
        "kilted",
        "simulation_interfaces/msg/SpawnEntity",
        "94a349a865ccf673c18c080520299c88c3d8d5f4842ecf1482d6c997ac4b69f9",
    ),
    (
        "kilted",
        "simulation_interfaces/msg/SpawnResult",
        "dbc277304b6c24bfb2a631cea8f52e2b005d583ec0a6c86b11613f5ce6486da1",
    ),
    (
        "lyrical",
        "simulation_interfaces/msg/Spawnable",
        "8675aa686f0df1ed7874a6ec210fdce1ac1c07f4e49fc26ec7fb6fe729f6772e",
    ),
]
"""Hashes shown by `ros2 topic info -v` or written by ROS's generator on other machines."""

# The table was made without these packages.
WITHOUT_HASHES = {
    *("simulation_interfaces", "vision_msgs", "tf2_msgs", "hmrsim_msgs"),
    "type_description_interfaces",  # GetTypeDescription nests all of its types
}


def checked_types() -> set[str]:
    """Return the types in the table and all that Pickup and Place nest."""
    actions = (Pickup.Goal, Pickup.Result, Place.Goal, Place.Result)
    nested = [one for cls in actions for one in structure(cls).describe()["referenced_type_descriptions"]]
    return {*(name for _, name in HASHES), *(one["type_name"] for one in nested)}


def field_type(cls: type[Message], name: str) -> dict[str, Any]:
    """Return the description of the type of one field."""
    fields = structure(cls).describe()["type_description"]["fields"]
    found: dict[str, Any] = next(field["type"] for field in fields if field["name"] == name)
    return found


@pytest.mark.parametrize("distro", DISTROS)
def test_hashes_are_ros(distro: str) -> None:
    """The types in the table have the hashes that are in the table."""
    expected = {name: found for (of, name), found in HASHES.items() if of == distro}

    assert expected == {name: structures(distro)[name].hash() for name in expected}


def test_hashes_were_seen() -> None:
    """Types have the hashes observed elsewhere."""
    assert SEEN == [(distro, name, structures(distro)[name].hash().removeprefix("RIHS01_")) for distro, name, _ in SEEN]


def test_every_hash_is_checked() -> None:
    """Each message is in the table, or nested in one that is."""
    unchecked = messages().keys() - checked_types()

    assert set() == {name for name in unchecked if name.partition("/")[0] not in WITHOUT_HASHES}


@pytest.mark.parametrize("distro", DISTROS)
def test_every_distribution_has_all_actions(distro: str) -> None:
    """The table has the same actions for all distributions."""
    expected = {name for has, name in HASHES if has == "kilted" and "/action/" in name}

    assert expected == {name for has, name in HASHES if has == distro and "/action/" in name}


def test_description_of_a_flat_message() -> None:
    """A description lists the fields in order, and references no types for primitives."""
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

    assert expected == structure(Time).describe()


def test_nested_types_are_sorted_by_name() -> None:
    """Nested types of any depth are described once, in order of name."""
    nested = structure(NavigateToPose.Goal).describe()["referenced_type_descriptions"]

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
    """A message without fields is described with the field that ROS adds."""
    assert field_type(Empty, "structure_needs_at_least_one_member")["type_id"] == 3
