"""Goals as typed on a command line."""

from __future__ import annotations

import pytest

from hmrsim.cli.exits import WrongUse
from hmrsim.cli.goal_text import read_goal, read_yaml
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import FollowWaypoints, NavigateToPose


def goal(text, kind=NavigateToPose.Goal):
    """Return the goal that a text stands for."""
    return read_goal(read_yaml(text), kind)


def test_integers_will_do_for_floats():
    """A coordinate may be written without a point."""
    position = goal("{pose: {pose: {position: {x: 512, y: 215}}}}").pose.pose.position

    assert (512.0, 215.0, 0.0) == (position.x, position.y, position.z)


@pytest.mark.parametrize(
    ("text", "value"), [("1e3", 1000.0), ("1.5e-3", 0.0015), ("-.5", -0.5), ("010", 10.0), ("+2", 2.0)]
)
def test_numbers_of_yaml_1_2(text, value):
    """Numbers are read as YAML 1.2 has them, unlike PyYAML by itself."""
    assert value == goal(f"{{pose: {{pose: {{position: {{x: {text}}}}}}}}}").pose.pose.position.x


def test_no_is_a_name():
    """An item may be called `no`."""
    assert "no" == goal("{target_name: no}", Pickup.Goal).target_name


def test_nothing_given_is_the_default():
    """`{}` is the goal with all of ROS's defaults."""
    assert NavigateToPose.Goal() == goal("{}")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("{pose: {pose: {position: {x: abc}}}}", "goal: pose.pose.position.x: expected a number, got 'abc'"),
        ("{pose: {pose: {position: {x: .nan}}}}", "goal: pose.pose.position.x: expected a finite number, got nan"),
        ("{pose: {pos: 1}}", "goal: pose.pos: unknown field; known fields: header, pose"),
        ("{pose: {header: {stamp: {sec: 1.5}}}}", "goal: pose.header.stamp.sec: expected an integer, got 1.5"),
        ("{pose: [1]}", "goal: pose: expected a mapping, got [1]"),
        ("{behavior_tree:x}", "goal: behavior_tree:x: put a space after the colon, as in 'behavior_tree: x'"),
        ("[1, 2]", "goal: expected a mapping, got [1, 2]"),
        ("~", "goal: expected a mapping, got nothing"),
        ("hello", "goal: expected a mapping, got 'hello'"),
        ("{behavior_tree: 12}", "goal: behavior_tree: expected a string (quote it if it looks like a number), got 12"),
    ],
)
def test_a_mistake_is_named_with_its_field(text, line):
    """A mistake says where it is, what was found and what was expected."""
    with pytest.raises(WrongUse) as caught:
        goal(text)

    assert line == str(caught.value)


def test_unknown_field_in_a_list():
    """An unknown field of a list's message is told with those that there are."""
    with pytest.raises(WrongUse, match=r"^goal: poses\.1\.q: unknown field; known fields: header, pose$"):
        goal("{poses: [{}, {q: 1}]}", FollowWaypoints.Goal)


def test_every_mistake_is_told():
    """Two mistakes are two lines."""
    with pytest.raises(WrongUse) as caught:
        goal("{pose: {pose: {position: {x: a, y: b}}}}")

    assert 2 == len(str(caught.value).splitlines())


@pytest.mark.parametrize(
    "text", ["{a: ", "", "{a: 1}}", "[" * 5000, "{a: &x [*x]}", "!!python/name:os.system {}", "\x00"]
)
def test_what_is_no_yaml_is_one_line(text):
    """Broken, empty, deep, circular and tagged YAML is refused in one line."""
    with pytest.raises(WrongUse, match=r"^goal: [^\n]*$"):
        read_yaml(text)


def test_a_key_given_twice_is_a_mistake():
    """The second of two equal keys is not silently taken."""
    with pytest.raises(WrongUse, match=r"^goal: a\.x: key 'x' is there twice"):
        read_yaml("{a: {x: 1, x: 2}}")
