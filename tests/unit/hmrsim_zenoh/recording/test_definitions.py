"""ROS types as text, read by a third-party parser."""

from __future__ import annotations

import pytest
from rosbags.typesys import Stores, get_types_from_msg, get_typestore

from hmrsim.actions import registry
from hmrsim.interfaces.geometry_msgs import PoseWithCovariance
from hmrsim.interfaces.nav_msgs import Odometry
from hmrsim.interfaces.rcl_interfaces import Log
from hmrsim.interfaces.sensor_msgs import BatteryState, CompressedImage
from hmrsim.interfaces.shape_msgs import SolidPrimitive
from hmrsim.interfaces.vision_msgs import Detection3DArray
from hmrsim.interfaces.visualization_msgs import MarkerArray
from hmrsim_zenoh.ros2.codec.structures import definition
from hmrsim_zenoh.ros2.codec.types import action_type, message_type

_OF_ACTIONS = [action_type(action).feedback for action in registry().values()]


def described(cls):
    """Return the definition of a message."""
    return definition(message_type(cls).structure, cls)


@pytest.mark.parametrize("cls", [Odometry, Log, BatteryState, CompressedImage, Detection3DArray, MarkerArray])
def test_the_text_is_the_type_that_ros_has(cls):
    """The hash of the definition, computed by a third party, is that of its own type."""
    ros = get_typestore(Stores.EMPTY)
    ros.register(get_types_from_msg(described(cls), cls.ros_type))

    assert message_type(cls).hash == ros.hash_rihs01(cls.ros_type)


@pytest.mark.parametrize("cls", [Log, CompressedImage, MarkerArray])
def test_new_messages_are_those_of_ros(cls):
    """The hash is the one that jazzy's own definition has."""
    assert get_typestore(Stores.ROS2_JAZZY).hash_rihs01(cls.ros_type) == message_type(cls).hash


@pytest.mark.parametrize("type_", _OF_ACTIONS, ids=lambda type_: type_.name)
def test_feedback_can_be_read_by_its_text(type_):
    """An empty nested type has a definition as well."""
    found = get_types_from_msg(definition(type_.structure), type_.name)

    assert ["goal_id", "feedback"] == [name for name, _ in found[type_.name][1]]


def test_nested_types_come_after_a_line():
    """Nested types follow 80 times `=` and the short name, as in rosbag2."""
    text = described(Log)

    assert f"{'=' * 80}\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n" == text[text.index("==") :]


def test_constants_have_the_type_of_the_field_that_they_are_for():
    assert "uint8 POWER_SUPPLY_STATUS_CHARGING=1\n" in described(BatteryState)


def test_a_fixed_array_has_its_size():
    assert "float64[36] covariance\n" in described(PoseWithCovariance)


def test_a_bounded_list_has_its_bound():
    assert "float64[<=3] dimensions\n" in described(SolidPrimitive)
