"""Messages are encoded as ROS encodes them, and invalid ones are rejected safely."""

from __future__ import annotations

import struct
from types import MappingProxyType
from typing import Any

import pytest

from hmrsim.actions import registry
from hmrsim.interfaces.action_msgs import CancelGoal, GoalStatusArray
from hmrsim.interfaces.builtin_interfaces import Time
from hmrsim.interfaces.geometry_msgs import Point, Pose, PoseStamped, PoseWithCovariance, Twist
from hmrsim.interfaces.moveit_msgs import AllowedCollisionEntry, AllowedCollisionMatrix, CollisionObject, Pickup
from hmrsim.interfaces.nav2_msgs import FollowPath, FollowWaypoints, NavigateToPose, WaypointStatus
from hmrsim.interfaces.octomap_msgs import Octomap
from hmrsim.interfaces.sensor_msgs import JointState
from hmrsim.interfaces.shape_msgs import SolidPrimitive
from hmrsim.interfaces.std_msgs import Empty, Header
from hmrsim.interfaces.unique_identifier_msgs import UUID
from hmrsim_zenoh.ros2.codec.decoder import MAX_BYTES, decoder
from hmrsim_zenoh.ros2.codec.layout import CdrError
from hmrsim_zenoh.ros2.codec.structures import Field, Kind, Structure
from hmrsim_zenoh.ros2.codec.types import ActionType, action_type, message_type

UUID_BYTES = bytes(range(16))
GOAL_ID = {"uuid": UUID_BYTES}

TEXT = message_type(Header)
"""A message of two numbers and a string."""


@pytest.fixture(scope="module")
def navigate_to_pose() -> ActionType:
    """Return the type of the most used action."""
    return action_type(registry()["navigate_to_pose"])


def names_and_entries(order: str, names: int, entries: int) -> bytes:
    """Return an allowed collision matrix of empty names and entries, in a byte order."""
    begin = bytes.fromhex("00010000" if order == "<" else "00000000")
    counts = [struct.pack(f"{order}I", count) for count in (names, entries)]
    return begin + counts[0] + bytes(4 * names) + counts[1] + bytes(4 * entries) + bytes(8)


class TestGolden:
    """Bytes that ROS's own code wrote."""

    def test_acceptance(self, navigate_to_pose: ActionType) -> None:
        """A number is aligned to its size: three bytes separate the flag and the stamp."""
        type_ = navigate_to_pose.send_goal.response

        assert type_.encode({"accepted": True, "stamp": {"sec": 9, "nanosec": 10}}) == bytes.fromhex(
            "0001000001000000090000000a000000"
        )

    def test_result(self, navigate_to_pose: ActionType) -> None:
        """A string has its length in bytes and a final zero, and nothing follows the last value."""
        type_ = navigate_to_pose.get_result.response
        result = NavigateToPose.Result(error_code=9000, error_msg="unlucky ✗")

        assert type_.encode({"status": 4, "result": result}) == bytes.fromhex(
            "00010000040028230c000000756e6c75636b7920e29c9700"
        )

    def test_goal(self, navigate_to_pose: ActionType) -> None:
        """Alignment counts from the first byte after the encapsulation; pycdr2 writes the same for free_fleet."""
        pose = {
            "header": {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "map"},
            "pose": {"position": {"x": 1.5, "y": -2.25}},
        }
        goal = NavigateToPose.Goal.model_validate({"pose": pose})

        assert navigate_to_pose.send_goal.request.encode({"goal_id": GOAL_ID, "goal": goal}) == bytes.fromhex(
            "00010000"
            "000102030405060708090a0b0c0d0e0f"
            "0100000002000000"
            "040000006d617000"
            "000000000000f83f00000000000002c00000000000000000"
            "000000000000000000000000000000000000000000000000000000000000f03f"
            "0100000000"
        )

    def test_nothing(self) -> None:
        """A message without fields is one byte."""
        assert message_type(Empty).encode(Empty()) == bytes.fromhex("0001000000")

    def test_no_numbers(self) -> None:
        """An empty list is its length alone, without padding for items."""
        assert message_type(JointState).encode(JointState()) == bytes.fromhex("00010000") + bytes(8) + bytes.fromhex(
            "01000000000000000000000000000000" + "0000000000000000"
        )


class TestWriting:
    """Values that can and can't be encoded."""

    @pytest.mark.parametrize("uuid", [UUID_BYTES, bytearray(UUID_BYTES), list(UUID_BYTES), tuple(UUID_BYTES)])
    def test_id_in_any_form(self, uuid: Any) -> None:
        """An id may be bytes or numbers."""
        assert message_type(UUID).encode({"uuid": uuid}) == b"\0\1\0\0" + UUID_BYTES

    @pytest.mark.parametrize(
        "values",
        [
            {"position": Point(x=1.0), "orientation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}},
            MappingProxyType(
                {"position": MappingProxyType({"x": 1.0, "y": 0, "z": 0}), "orientation": Pose().orientation}
            ),
            Pose(position=Point(x=1.0)),
        ],
    )
    def test_values_in_any_form(self, values: Any) -> None:
        """Messages, dicts and other mappings can nest each other."""
        expected = message_type(Pose).encode(Pose(position=Point(x=1.0)).model_dump())

        assert expected == message_type(Pose).encode(values)

    @pytest.mark.parametrize(
        ("cls", "values", "error"),
        [
            (Time, {"sec": 0}, "builtin_interfaces/msg/Time: nanosec: the value of 'nanosec' is missing"),
            (Time, {"sec": 2**31, "nanosec": 0}, "Time: sec: 2147483648 is not a valid int32"),
            (Time, {"sec": 0, "nanosec": -1}, "Time: nanosec: -1 is not a valid uint32"),
            (Time, {"sec": 0.5, "nanosec": 0}, "Time: sec: 0.5 is not a valid int32"),
            (Point, {"x": 0.0, "y": "1", "z": 0.0}, "Point: y: '1' is not a valid double"),
            (Point, {"x": 0.0, "y": 10**400, "z": 0.0}, "Point: y: 10{10}"),
            (
                FollowPath.Feedback,
                {"distance_to_goal": 1e39, "speed": 0.0},
                "distance_to_goal: 1e[+]39 is not a valid float",
            ),
            (Header, {"stamp": Time(), "frame_id": b"map"}, "Header: frame_id: b'map' is not a string"),
            (Header, {"stamp": Time(), "frame_id": "\ud800"}, "Header: frame_id: .* has no UTF-8: surrogates"),
            (Header, {"stamp": 1, "frame_id": ""}, "Header: stamp.sec: 1 is not a message"),
            (UUID, {"uuid": bytes(15)}, "UUID: uuid: 15 items; exactly 16 are required"),
            (UUID, {"uuid": 16}, "UUID: uuid: 16 is not a list"),
            (UUID, {"uuid": [256] * 16}, r"UUID: uuid\[0\]: 256 is not a valid uint8"),
            (UUID, {"uuid": "0123456789abcdef"}, "UUID: uuid: '0123456789abcdef' is not a list"),
            (PoseWithCovariance, {"pose": Pose(), "covariance": [0.0]}, "covariance: 1 items; exactly 36 are required"),
            (
                SolidPrimitive,
                {"type": 1, "dimensions": [0.0] * 4, "polygon": {"points": []}},
                "dimensions: 4 items; at most 3 are allowed",
            ),
            (
                CancelGoal.Response,
                {"return_code": 0, "goals_canceling": [{"goal_id": UUID(), "stamp": {"sec": 0, "nanosec": "now"}}]},
                r"goals_canceling\[0\].stamp.nanosec: 'now' is not a valid uint32",
            ),
        ],
    )
    def test_what_does_not_fit(self, cls: Any, values: Any, error: str) -> None:
        """The error names the field and the value that does not fit."""
        with pytest.raises(CdrError, match=error):
            message_type(cls).encode(values)


class TestReading:
    """Bytes that can and can't be decoded."""

    def test_other_order_of_bytes(self) -> None:
        """Big-endian messages are decoded as well."""
        data = bytes.fromhex("00000000" + "00000001" + "00000002" + "00000004" + "6d617000")

        assert TEXT.decode(data) == {"stamp": {"sec": 1, "nanosec": 2}, "frame_id": "map"}

    def test_what_comes_after(self) -> None:
        """Bytes after the message are ignored, as in ROS."""
        assert message_type(Time).decode(bytes.fromhex("00010003" + "0100000002000000" + "ffffff")) == {
            "sec": 1,
            "nanosec": 2,
        }

    @pytest.mark.parametrize(
        ("text", "expected"),
        [
            ("04000000" + "6d617000", "map"),
            ("03000000" + "6d6170", "map"),
            ("01000000" + "00", ""),
            ("00000000", ""),
            ("04000000" + "6d006100", "m\0a"),
            ("02000000" + "0000", "\0"),
        ],
    )
    def test_texts(self, text: str, expected: str) -> None:
        """A string may lack its final zero or have no bytes, as Fast-CDR allows."""
        assert expected == TEXT.decode(bytes.fromhex("00010000" + "0000000000000000" + text))["frame_id"]

    def test_missing_padding_of_nothing(self) -> None:
        """The byte of a message without fields may be missing, as not all implementations write it."""
        assert message_type(Empty).decode(bytes.fromhex("00010000")) == {}

    def test_nested_nothing(self) -> None:
        """A nested message without fields is an empty dict."""
        assert message_type(FollowPath.Result).decode(bytes.fromhex("00010000" + "00000100" + "0100000000")) == {
            "result": {},
            "error_code": 1,
            "error_msg": "",
        }

    @pytest.mark.parametrize(
        ("data", "error"),
        [
            ("", "0 bytes are not CDR, which has an encapsulation of 4"),
            ("000100", "3 bytes are not CDR"),
            ("00030000", "encapsulation 0003 is not plain CDR, which is 0001 or 0000"),
            ("0007000000", "encapsulation 0007"),
            ("00010000", "Header: stamp.sec: the message ends within the value, at byte 4 of 4"),
            ("00010000" + "00000000", "Header: stamp.nanosec: the message ends within the value, at byte 8 of 8"),
            ("00010000" + "00" * 10, "Header: frame_id: the message ends within the value"),
            ("00010000" + "00" * 8 + "05000000" + "6d617000", "frame_id: a string of 5 bytes does not fit in the 4"),
            ("00010000" + "00" * 8 + "ffffffff" + "6d617000", "frame_id: a string of 4294967295 bytes does not fit"),
            ("00010000" + "00" * 8 + "04000000" + "6dff7000", "frame_id: invalid UTF-8: invalid start byte"),
            ("00000000" + "00" * 8 + "00000005" + "6d617000", "frame_id: a string of 5 bytes does not fit in the 4"),
        ],
    )
    def test_broken_bytes(self, data: str, error: str) -> None:
        """The error gives the problem, the field and the byte."""
        with pytest.raises(CdrError, match=error):
            TEXT.decode(bytes.fromhex(data))

    def test_neither_true_nor_false(self, navigate_to_pose: ActionType) -> None:
        """A boolean is 0 or 1."""
        with pytest.raises(CdrError, match=r"accepted: 2 is neither true \(1\) nor false \(0\), at byte 5 of 16"):
            navigate_to_pose.send_goal.response.decode(bytes.fromhex("0001000002000000090000000a000000"))

    def test_neither_true_nor_false_in_a_list(self) -> None:
        """A boolean in a list is 0 or 1."""
        with pytest.raises(CdrError, match=r"enabled\[1\]: 2 is neither"):
            message_type(AllowedCollisionEntry).decode(bytes.fromhex("00010000" + "03000000" + "010201"))

    def test_place_in_a_list(self) -> None:
        """The error gives the index of the invalid item."""
        data = message_type(AllowedCollisionMatrix).encode(AllowedCollisionMatrix(entry_names=["a", "b"]))
        broken = data.replace(b"b", b"\xff")

        with pytest.raises(CdrError, match=r"AllowedCollisionMatrix: entry_names\[1\]: invalid UTF-8"):
            message_type(AllowedCollisionMatrix).decode(broken)

    def test_too_many_in_a_bounded_list(self) -> None:
        """A bounded list can't have more items than its bound."""
        data = bytes.fromhex("00010000" + "01000000" + "04000000") + bytes(40)

        with pytest.raises(CdrError, match="dimensions: 4 items; at most 3 are allowed"):
            message_type(SolidPrimitive).decode(data)

    @pytest.mark.parametrize(
        ("cls", "before", "error"),
        [
            (GoalStatusArray, b"", "status_list: 4294967295 items do not fit in the 0 remaining bytes"),
            (AllowedCollisionEntry, b"", "enabled: 4294967295 items"),
            (AllowedCollisionMatrix, b"", "entry_names: 4294967295 items"),
            (JointState, bytes(8) + b"\1\0\0\0\0\0\0\0" + bytes(4), "position: 4294967295 items"),
            (Octomap, bytes(8) + b"\1\0\0\0\0\0\0\0" + b"\1\0\0\0" + bytes(12), "data: 4294967295 items"),
        ],
    )
    def test_lists_that_are_longer_than_the_message(self, cls: Any, before: bytes, error: str) -> None:
        """A list longer than the rest of the message is rejected before memory is allocated."""
        with pytest.raises(CdrError, match=error):
            message_type(cls).decode(b"\0\1\0\0" + before + b"\xff\xff\xff\xff")

    @pytest.mark.parametrize("order", ["<", ">"])
    def test_most_messages_and_texts(self, order: str) -> None:
        """The lists of a message have at most 10,000 messages and strings, to limit the time."""
        type_ = message_type(AllowedCollisionMatrix)
        values = type_.decode(names_and_entries(order, 6_000, 4_000))

        assert (6_000, 4_000) == (len(values["entry_names"]), len(values["entry_values"]))
        with pytest.raises(
            CdrError, match="entry_values: more than 10000 messages and strings in the lists of one mess"
        ):
            type_.decode(names_and_entries(order, 6_000, 4_001))

    def test_nested_messages_count(self) -> None:
        """A message in a list counts with all nested messages: a stamped pose counts as six."""
        type_ = message_type(FollowWaypoints.Goal)
        poses = [PoseStamped().model_dump()] * 1_667
        data = type_.encode({"number_of_loops": 0, "goal_index": 0, "poses": poses[:1_666]})
        larger = type_.encode({"number_of_loops": 0, "goal_index": 0, "poses": poses})

        assert 1_666 == len(type_.decode(data)["poses"])
        with pytest.raises(CdrError, match="FollowWaypoints_Goal: poses: more than 10000 messages"):
            type_.decode(larger)

    def test_many_numbers(self) -> None:
        """Lists of numbers may be as long as a message can be."""
        data = bytes.fromhex("00010000" + "40420f00") + bytes(1_000_000)

        assert 1_000_000 == len(message_type(AllowedCollisionEntry).decode(data)["enabled"])

    def test_list_of_nothing(self) -> None:
        """A list of messages without fields has no more items than there are bytes."""
        nothing = Field("nothings", kind=Kind.UNBOUNDED, nested=message_type(Empty).structure, path=("nothings",))
        decode = decoder(Structure("test_msgs/msg/Nothings", (nothing,)))

        assert decode(bytes.fromhex("00010000" + "02000000" + "0000")) == {"nothings": [{}, {}]}
        with pytest.raises(CdrError, match="nothings: 16777216 items do not fit in the 2 remaining bytes"):
            decode(bytes.fromhex("00010000" + "00000001" + "0000"))

    def test_longest_message(self) -> None:
        """A message above the size limit is rejected unread."""
        with pytest.raises(CdrError, match="Header: 4194305 bytes; at most 4194304 are read"):
            TEXT.decode(b"\0\1\0\0" + bytes(MAX_BYTES - 3))

    def test_place_in_a_long_message(self) -> None:
        """The error about a long message gives the place, too."""
        data = bytes.fromhex("00010000" + "00010100") + bytes(65791) + b"\2"

        with pytest.raises(CdrError, match=r"AllowedCollisionEntry: enabled\[65791\]: 2 is neither"):
            message_type(AllowedCollisionEntry).decode(data)

    @pytest.mark.parametrize("cls", [Pickup.Goal, CollisionObject, WaypointStatus, PoseStamped, Twist])
    def test_every_truncation(self, cls: Any) -> None:
        """A truncated message is rejected, at any length."""
        data = message_type(cls).encode(cls())

        for length in range(len(data)):
            with pytest.raises(CdrError):
                message_type(cls).decode(data[:length])
