"""The values that messages accept and reject, and their defaults."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

import pytest
from pydantic import TypeAdapter, ValidationError
from pydantic_core import to_json

import hmrsim
from hmrsim.interfaces import nav_msgs
from hmrsim.interfaces.action_msgs import CancelGoal, GoalStatus
from hmrsim.interfaces.builtin_interfaces import Duration, Time
from hmrsim.interfaces.geometry_msgs import PoseStamped, PoseWithCovariance, Quaternion, Vector3
from hmrsim.interfaces.message import (
    Array,
    Byte,
    Float64,
    Int8,
    Int16,
    Int32,
    Int64,
    Message,
    UInt8,
    UInt16,
    UInt32,
    UInt64,
    unbuilt,
)
from hmrsim.interfaces.moveit_msgs import Grasp, MoveItErrorCodes, Pickup
from hmrsim.interfaces.nav2_msgs import (
    BackUp,
    ComputePathToPose,
    DockRobot,
    DriveOnHeading,
    FollowPath,
    FollowWaypoints,
    NavigateThroughPoses,
    NavigateToPose,
    Spin,
    UndockRobot,
    Wait,
)
from hmrsim.interfaces.quantities import ANGLE, REAL_TIME_FACTOR, SECONDS, SIGNED_SPEED, SPEED, flaw
from hmrsim.interfaces.rosgraph_msgs import Clock
from hmrsim.interfaces.shape_msgs import SolidPrimitive
from hmrsim.interfaces.std_msgs import Header
from hmrsim.interfaces.unique_identifier_msgs import UUID
from hmrsim.protocol.goal import GoalStatus as Status
from tests.cases import case
from tests.ros_types import messages

IMPORT_ALL = """
import importlib, pkgutil, sys
import hmrsim.interfaces
for module in pkgutil.iter_modules(hmrsim.interfaces.__path__, "hmrsim.interfaces."):
    importlib.import_module(module.name)
from hmrsim.interfaces.message import Message, unbuilt
from hmrsim.interfaces.moveit_msgs import Pickup
unbuilt(Pickup.Goal)
print([cls.ros_type for cls in Message.__subclasses__() if cls.__pydantic_complete__])
print([name for name in ("simpy", "zenoh", "py_trees", "networkx") if name in sys.modules])
"""

SAMPLES = {bool: True, int: 7, float: 0.1, str: "wall_e ✗"}


def filled(cls: type[Message]) -> Message:
    return cls(**{name: _value(field.annotation, field.metadata) for name, field in cls.model_fields.items()})


def _value(annotation: Any, metadata: list[Any]) -> Any:
    if get_origin(annotation) is list:
        size = next((mark.size for mark in metadata if isinstance(mark, Array)), 2)
        item = get_args(annotation)[0]
        return [_value(getattr(item, "__origin__", item), []) for _ in range(size)]
    return SAMPLES[annotation] if annotation in SAMPLES else filled(annotation)


def test_every_field_has_a_default() -> None:
    for name, cls in messages().items():
        assert cls() == cls.model_validate_json("{}"), name


def test_default_survives_json() -> None:
    for name, cls in messages().items():
        message = cls()

        assert message == cls.model_validate_json(message.model_dump_json()), name


def test_an_unbuilt_message_has_its_plain_values() -> None:
    for name, cls in messages().items():
        assert cls().model_dump_json().encode() == to_json(unbuilt(cls)), name
    assert to_json(unbuilt(Pickup.Goal, target_name="cup")) == Pickup.Goal(target_name="cup").model_dump_json().encode()


def test_content_survives_json() -> None:
    for name, cls in messages().items():
        message = filled(cls)

        assert message == cls.model_validate_json(message.model_dump_json()), name


def test_unknown_field_is_rejected() -> None:
    for name, cls in messages().items():
        with case(name), pytest.raises(ValidationError, match="Extra inputs are not permitted"):
            cls.model_validate_json('{"no_such_field": 1}')


def test_class_has_a_docstring() -> None:
    assert [] == [name for name, cls in messages().items() if not vars(cls)["__doc__"]]


@pytest.mark.parametrize(
    ("cls", "ros_type"),
    [
        (Time, "builtin_interfaces/msg/Time"),
        (NavigateToPose.Goal, "nav2_msgs/action/NavigateToPose_Goal"),
        (Pickup.Feedback, "moveit_msgs/action/Pickup_Feedback"),
        (CancelGoal.Response, "action_msgs/srv/CancelGoal_Response"),
    ],
)
def test_ros_type(cls: type[Message], ros_type: str) -> None:
    assert ros_type == cls.ros_type


@pytest.mark.parametrize(
    ("message", "expected"),
    [
        (Time(), {"sec": 0, "nanosec": 0}),
        (Quaternion(), {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}),
        (Header(), {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""}),
        (Clock(), {"clock": {"sec": 0, "nanosec": 0}}),
        (UUID(), {"uuid": [0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]}),
        (MoveItErrorCodes(), {"val": 0, "message": "", "source": ""}),
        (UndockRobot.Goal(), {"dock_type": "", "max_undocking_time": 30.0}),
        (DockRobot.Result(), {"success": True, "error_code": 0, "num_retries": 0, "error_msg": ""}),
    ],
    ids=lambda value: value.ros_type if isinstance(value, Message) else "",
)
def test_defaults(message: Message, expected: dict[str, object]) -> None:
    assert expected == message.model_dump()


def test_docking_defaults() -> None:
    goal = DockRobot.Goal()

    assert (goal.use_dock_id, goal.navigate_to_staging_pose, goal.max_staging_time) == (True, True, 1000.0)


def test_default_lists_are_not_shared() -> None:
    assert Grasp().allowed_touch_objects is not Grasp().allowed_touch_objects
    assert Grasp().pre_grasp_posture is not Grasp().pre_grasp_posture


def test_default_messages_without_lists_are_shared() -> None:
    """A message costs no more than the fields that it is given."""
    assert Grasp().grasp_pose is Grasp().grasp_pose


@pytest.mark.parametrize("value", [float("nan"), float("inf"), float("-inf")])
def test_infinite_values_are_rejected(value: float) -> None:
    with pytest.raises(ValidationError, match="Input should be a finite number"):
        Vector3(x=value)


@pytest.mark.parametrize("text", ["NaN", "Infinity", "-Infinity", "1e999"])
def test_infinite_values_are_rejected_in_json(text: str) -> None:
    with pytest.raises(ValidationError, match="Input should be a finite number"):
        PoseStamped.model_validate_json(f'{{"pose": {{"position": {{"x": {text}}}}}}}')


@pytest.mark.parametrize(
    ("cls", "text", "error"),
    [
        (Vector3, '{"x": "1"}', "valid number"),
        (Vector3, '{"x": true}', "valid number"),
        (Vector3, '{"x": null}', "valid number"),
        (Time, '{"sec": 1.0}', "valid integer"),
        (Time, '{"sec": "1"}', "valid integer"),
        (Time, '{"sec": true}', "valid integer"),
        (Header, '{"frame_id": 1}', "valid string"),
        (Header, '{"stamp": 1}', "should be an object"),
        (DockRobot.Goal, '{"use_dock_id": 1}', "valid boolean"),
        (Grasp, '{"allowed_touch_objects": "all"}', "valid array"),
    ],
)
def test_wrong_type_is_rejected(cls: type[Message], text: str, error: str) -> None:
    with pytest.raises(ValidationError, match=error):
        cls.model_validate_json(text)


def test_whole_number_is_a_float() -> None:
    assert repr(Vector3.model_validate_json('{"x": 1}').x) == "1.0"


@pytest.mark.parametrize(
    ("integer", "least", "most"),
    [
        (Int8, -128, 127),
        (UInt8, 0, 255),
        (Byte, 0, 255),
        (Int16, -32768, 32767),
        (UInt16, 0, 65535),
        (Int32, -2147483648, 2147483647),
        (UInt32, 0, 4294967295),
        (Int64, -9223372036854775808, 9223372036854775807),
        (UInt64, 0, 18446744073709551615),
    ],
)
class TestIntegers:
    def test_limits_are_accepted(self, integer: Any, least: int, most: int) -> None:
        adapter = TypeAdapter[int](integer)

        assert [adapter.validate_python(value) for value in (least, most)] == [least, most]

    def test_one_less_than_the_minimum_is_rejected(self, integer: Any, least: int, most: int) -> None:
        del most
        with pytest.raises(ValidationError, match="greater than or equal to"):
            TypeAdapter(integer).validate_python(least - 1)

    def test_one_more_than_the_maximum_is_rejected(self, integer: Any, least: int, most: int) -> None:
        del least
        with pytest.raises(ValidationError, match="less than or equal to"):
            TypeAdapter(integer).validate_python(most + 1)


@pytest.mark.parametrize(
    ("cls", "values", "error"),
    [
        (UUID, {"uuid": [0] * 15}, "at least 16 items"),
        (UUID, {"uuid": [0] * 17}, "at most 16 items"),
        (UUID, {"uuid": [256] * 16}, "less than or equal to 255"),
        (PoseWithCovariance, {"covariance": [0.0]}, "at least 36 items"),
        (SolidPrimitive, {"dimensions": [1.0] * 4}, "at most 3 items"),
    ],
)
def test_array_size_is_checked(cls: type[Message], values: dict[str, object], error: str) -> None:
    with pytest.raises(ValidationError, match=error):
        cls(**values)


def test_message_is_immutable() -> None:
    message = Vector3()

    with pytest.raises(ValidationError, match="Instance is frozen"):
        message.x = 1.0


def test_statuses_are_those_of_a_goals_life() -> None:
    assert {status.name: status.value for status in Status} == {
        name.removeprefix("STATUS_"): getattr(GoalStatus, name)
        for name in vars(GoalStatus)
        if name.startswith("STATUS_")
    }


@pytest.mark.parametrize(
    ("code", "expected"),
    [
        (FollowPath.Result.UNKNOWN, 100),
        (FollowPath.Result.NO_VALID_CONTROL, 106),
        (ComputePathToPose.Result.GOAL_OUTSIDE_MAP, 204),
        (ComputePathToPose.Result.NO_VALID_PATH, 208),
        (FollowWaypoints.Result.NO_VALID_WAYPOINTS, 602),
        (Spin.Result.COLLISION_AHEAD, 703),
        (BackUp.Result.INVALID_INPUT, 713),
        (DriveOnHeading.Result.INVALID_INPUT, 724),
        (Wait.Result.UNKNOWN, 740),
        (DockRobot.Result.DOCK_NOT_IN_DB, 901),
        (UndockRobot.Result.UNKNOWN, 999),
        (NavigateToPose.Result.GOAL_REJECTED, 1),
        (NavigateToPose.Result.UNKNOWN, 9000),
        (NavigateToPose.Result.TIMEOUT, 9003),
        (NavigateThroughPoses.Result.UNKNOWN, 9100),
        (CancelGoal.Response.ERROR_GOAL_TERMINATED, 3),
        (MoveItErrorCodes.SUCCESS, 1),
        (MoveItErrorCodes.FAILURE, 99999),
        (MoveItErrorCodes.PREEMPTED, -7),
        (MoveItErrorCodes.INVALID_GOAL_CONSTRAINTS, -16),
        (MoveItErrorCodes.INVALID_ROBOT_STATE, -17),
        (MoveItErrorCodes.INVALID_OBJECT_NAME, -19),
    ],
)
def test_error_codes(code: int, expected: int) -> None:
    assert code == expected


@pytest.mark.parametrize(("seconds", "sec", "nanosec"), [(1.5, 1, 500_000_000), (-0.25, -1, 750_000_000)])
def test_duration_of_seconds(seconds: float, sec: int, nanosec: int) -> None:
    assert Duration(sec=sec, nanosec=nanosec) == Duration.from_seconds(seconds)


def test_imports_build_no_validator() -> None:
    root = Path(hmrsim.__file__).parents[1]
    done = subprocess.run([sys.executable, "-c", IMPORT_ALL], cwd=root, capture_output=True, text=True, check=True)

    assert done.stdout == "[]\n[]\n"


@pytest.mark.parametrize("kind", [int, str, list[int], dict[str, float], float | None])
def test_a_field_that_ros_can_not_represent_is_rejected(kind):
    with pytest.raises(TypeError, match=r"/msg/.*Odd: field 'x' has no ROS type; use a Message, or one of"):
        type("Odd", (Message,), {"__annotations__": {"x": kind}, "__module__": "odd_msgs"})


@pytest.mark.parametrize(
    ("quantity", "value", "wrong"),
    [
        (SECONDS, 0.0, ""),
        (SECONDS, -0.5, "-0.5 s is not from 0 to 1e+09 s"),
        (ANGLE, -6.28, ""),
        (ANGLE, 1.7e308, "1.7e+308 rad is not from -10000 to 10000 rad"),
        (SIGNED_SPEED, 0.0, ""),
        (SIGNED_SPEED, -2.0, ""),
        (SIGNED_SPEED, 5e-324, "4.94066e-324 units/s is not 0, or from 1e-09 to 1e+09 units/s, or its negative"),
        (REAL_TIME_FACTOR, 5e-324, "4.94066e-324 is not 0, or from 1e-06 to 1e+06"),
    ],
)
def test_a_value_out_of_range_is_reported_with_the_range(quantity, value, wrong):
    assert wrong == quantity.flaw(value)


class _Uphill(Message):
    slope: Annotated[Float64, ANGLE]
    speed: Annotated[Float64, SPEED] = 0.0


@pytest.mark.parametrize(
    ("message", "wrong"),
    [
        (NavigateToPose.Goal(), ""),
        (_Uphill(slope=1.0), "speed: 0 units/s is not from 1e-09 to 1e+09 units/s"),
        (_Uphill(slope=1e5), "slope: 100000 rad is not from -10000 to 10000 rad"),
        (Spin.Goal(target_yaw=1e5), "target_yaw: 100000 rad is not from -10000 to 10000 rad"),
        (
            DriveOnHeading.Goal(speed=1e-10),
            "speed: 1e-10 units/s is not 0, or from 1e-09 to 1e+09 units/s, or its negative",
        ),
        (
            FollowPath.Goal(
                path=nav_msgs.Path(
                    poses=[PoseStamped(), PoseStamped.model_validate({"pose": {"orientation": {"z": 1e7}}})]
                )
            ),
            "path.poses.1.pose.orientation.z: 1e+07 is not from -1e+06 to 1e+06",
        ),
        (Quaternion(w=-1e300), "w: -1e+300 is not from -1e+06 to 1e+06"),
    ],
)
def test_a_message_is_reported_with_the_path_to_its_value(message, wrong):
    assert wrong == flaw(message)
