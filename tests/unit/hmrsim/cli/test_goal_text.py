"""Goals and messages on the command line."""

from __future__ import annotations

import pytest

from hmrsim.actions import registry
from hmrsim.cli.goal_text import example_of, one_line, read_goal, read_yaml, without_defaults
from hmrsim.cli.options import WrongUse
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.geometry_msgs import PoseStamped
from hmrsim.interfaces.moveit_msgs import MoveItErrorCodes, Pickup
from hmrsim.interfaces.nav2_msgs import FollowWaypoints, NavigateToPose, Wait
from hmrsim.interfaces.std_msgs import Header
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.connection import Read
from tests.fake_connection import FakeConnection


def goal(text, kind=NavigateToPose.Goal):
    return read_goal(read_yaml(text), kind)


@pytest.mark.parametrize(
    ("text", "value"), [("512", 512.0), ("1e3", 1000.0), ("1.5e-3", 0.0015), ("-.5", -0.5), ("010", 10.0), ("+2", 2.0)]
)
def test_numbers_are_read_as_in_yaml_1_2(text, value):
    assert value == goal(f"{{pose: {{pose: {{position: {{x: {text}}}}}}}}}").pose.pose.position.x


def test_the_word_no_is_a_name():
    assert "no" == goal("{target_name: no}", Pickup.Goal).target_name


def test_an_empty_goal_has_ros_defaults():
    assert NavigateToPose.Goal() == goal("{}")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("{pose: {pose: {position: {x: abc}}}}", "goal: pose.pose.position.x: expected a number, got 'abc'"),
        ("{pose: {pose: {position: {x: .nan}}}}", "goal: pose.pose.position.x: expected a finite number, got nan"),
        ("{pose: {pos: 1}}", "goal: pose.pos: unknown field; did you mean 'pose'?"),
        ("{pose: {where: 1}}", "goal: pose.where: unknown field; known fields: header, pose"),
        ("{pose: {header: {stamp: {sec: 1.5}}}}", "goal: pose.header.stamp.sec: expected an integer, got 1.5"),
        ("{pose: [1]}", "goal: pose: expected the name of a place, [x, y], [x, y, yaw] or a mapping, got [1]"),
        ("{behavior_tree:x}", "goal: behavior_tree:x: put a space after the colon, as in 'behavior_tree: x'"),
        ("[1, 2]", "goal: expected a mapping, got [1, 2]"),
        ("~", "goal: expected a mapping, got nothing"),
        ("hello", "goal: expected a mapping, got 'hello'"),
        ("{behavior_tree: 12}", "goal: behavior_tree: expected a string (quote it if it looks like a number), got 12"),
    ],
)
def test_an_error_names_its_field(text, line):
    with pytest.raises(WrongUse) as caught:
        goal(text)

    assert line == str(caught.value)


def test_an_error_in_a_list_lists_the_known_fields():
    with pytest.raises(WrongUse, match=r"^goal: poses\.1\.q: unknown field; known fields: header, pose$"):
        goal("{poses: [{}, {q: 1}]}", FollowWaypoints.Goal)


def test_every_error_is_a_line():
    with pytest.raises(WrongUse) as caught:
        goal("{pose: {pose: {position: {x: a, y: b}}}}")

    assert 2 == len(str(caught.value).splitlines())


@pytest.mark.parametrize(
    "text", ["{a: ", "", "{a: 1}}", "[" * 5000, "{a: &x [*x]}", "!!python/name:os.system {}", "\x00"]
)
def test_invalid_yaml_is_one_line(text):
    with pytest.raises(WrongUse, match=r"^goal: [^\n]*$"):
        read_yaml(text)


def test_a_duplicate_key_is_an_error():
    with pytest.raises(WrongUse, match=r"^goal: a\.x: key 'x' is there twice"):
        read_yaml("{a: {x: 1, x: 2}}")


@pytest.mark.parametrize(
    ("message", "shown"),
    [
        (Pickup.Result(error_code=MoveItErrorCodes(val=1)), {"error_code": {"val": 1}, "planning_time": 0.0}),
        (Wait.Result(), {"total_elapsed_time": {"sec": 0, "nanosec": 0}, "error_code": 0}),
        (NavigateToPose.Result(error_code=208, error_msg="no way"), {"error_code": 208, "error_msg": "no way"}),
    ],
)
def test_default_parts_are_omitted(message, shown):
    assert shown == without_defaults(message)


def test_a_position_at_the_origin_is_shown():
    stamped = PoseStamped(header=Header(frame_id="map"))

    assert {"position": {"x": 0.0, "y": 0.0, "z": 0.0}} == without_defaults(stamped)["pose"]


def test_whole_numbers_are_exact():
    assert {"sec": 1_234_567_891, "nanosec": 0} == without_defaults(Duration(sec=1_234_567_891))


def test_one_line_shows_times_points_and_numbers():
    """Texts and lists that are empty are left out."""
    feedback = NavigateToPose.Feedback.model_validate(
        {
            "current_pose": {"pose": {"position": {"x": 6, "y": 1.237}}},
            "navigation_time": {"sec": 3, "nanosec": 200_000_000},
            "distance_remaining": 4.4321,
        }
    )

    assert one_line(feedback) == (
        "current_pose (6.00, 1.24), navigation_time 3.2 s, estimated_time_remaining 0.0 s, number_of_recoveries 0, "
        "distance_remaining 4.43"
    )


@pytest.mark.parametrize("scene", [b"[", b"{}", b'{"fixtures": 3, "items": []}', b'{"fixtures": [{}], "items": []}'])
def test_an_example_needs_no_readable_scene(scene):
    """A simulator of another version may describe its world otherwise."""
    connection = FakeConnection()
    connection.script[Read] = [scene]
    dock = registry()["dock_robot"]
    with Client(session=connection, clock="realtime") as client:
        assert dock.example == example_of(client, dock, "wall_e")
