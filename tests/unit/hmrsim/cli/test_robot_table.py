"""The live table of a simulator's robots."""

from __future__ import annotations

import io
from types import SimpleNamespace

import pytest
from rich.console import Console

from hmrsim.cli.robot_table import HostTable, LastGoals
from hmrsim.interfaces.moveit_msgs import Pickup
from hmrsim.interfaces.nav2_msgs import NavigateToPose
from hmrsim.protocol.commands import SendGoal
from hmrsim.protocol.goal import GoalStatus
from hmrsim.protocol.outputs import GoalChanged
from hmrsim.protocol.topics import Topic
from hmrsim.simulation.simulator import Simulator
from hmrsim.world_checks import load_world

MEDICINE_ROOM = NavigateToPose.Goal.model_validate({"pose": {"pose": {"position": {"x": 512.0, "y": 215.0}}}})


@pytest.fixture
def host():
    """Return a stand-in for a host."""
    return SimpleNamespace(
        simulator=Simulator(load_world("scenario1").world), pacing=SimpleNamespace(real_time_factor=2.0, lag=0.0)
    )


def drawn(host, *events, width=120, height=30):
    """Return the table as text, after these events."""
    console = Console(file=io.StringIO(), width=width, height=height)
    goals = LastGoals()
    table = HostTable(host, "scenario 1", goals, console)
    for event in events:
        goals.emit(event)
    console.print(table.table())
    return console.file.getvalue()


def ended(status, result):
    """Return the end of a goal."""
    return GoalChanged(1, "wall_e", "navigate_to_pose", "1" * 32, status, result=result)


def test_table_of_a_robot_that_stands(host):
    """A robot at rest is shown where it stands."""
    text = drawn(host)

    assert "scenario 1   0.0 s   at 2 x" in text
    assert ["wall_e", "carrier", "515.00", "80.00", "0.00", "-"] == text.splitlines()[3].split()


def test_table_of_a_robot_that_drives(host):
    """A driving robot is shown with its action and the remaining distance."""
    host.simulator.submit(SendGoal("wall_e", "navigate_to_pose", MEDICINE_ROOM))
    host.simulator.advance(1.0)

    (row,) = [line for line in drawn(host).splitlines() if "wall_e" in line]
    assert "navigate_to_pose" in row
    assert "232.00" in row


def test_table_shows_what_is_carried(host):
    """An item in the claw is named."""
    host.simulator.submit(SendGoal("wall_e", "navigate_to_pose", MEDICINE_ROOM))
    host.simulator.run()
    host.simulator.submit(SendGoal("wall_e", "pickup", Pickup.Goal(target_name="medicine")))
    host.simulator.run()

    assert " medicine " in drawn(host)


def test_table_shows_how_the_last_goal_ended(host):
    """A successful goal is named, and a failed goal is shown with its error."""
    done = ended(GoalStatus.SUCCEEDED, NavigateToPose.Result())
    failed = ended(GoalStatus.ABORTED, NavigateToPose.Result(error_code=208, error_msg="no way"))

    assert "SUCCEEDED navigate_to_pose" in drawn(host, failed, done)
    assert "ABORTED: no way" in drawn(host, done, failed)


def test_the_end_of_a_goal_has_a_colour(host):
    """A failed goal is red."""
    console = Console(file=io.StringIO(), width=120, force_terminal=True, color_system="standard")
    goals = LastGoals()
    table = HostTable(host, "scenario 1", goals, console)
    goals.emit(ended(GoalStatus.ABORTED, NavigateToPose.Result(error_code=208, error_msg="no way")))
    console.print(table.table())

    assert "\x1b[31mABORTED: no way" in console.file.getvalue()


@pytest.mark.parametrize("width", [20, 40, 80, 120])
def test_what_the_terminal_echoes_has_room(host, width):
    """A ^C after the last line does not wrap, so that the next table replaces this one."""
    lines = drawn(host, width=width).splitlines()

    assert all(len(line + "^C") <= width for line in lines)


@pytest.mark.parametrize(
    ("width", "headings"),
    [
        (120, "robot type x, y yaw does remaining carries last goal"),
        (80, "robot x, y does remaining last goal"),
        (40, "robot does"),
        (10, "robot"),
    ],
)
def test_table_leaves_out_columns_for_which_there_is_no_room(host, width, headings):
    """Each robot has one line, however narrow the terminal is."""
    lines = drawn(host, width=width).splitlines()

    assert headings.split() == lines[1].split()
    assert 4 == len(lines)


def test_table_shows_the_lag_or_a_free_clock(host):
    """The title shows the lag, or that time runs as fast as possible."""
    host.pacing.real_time_factor, host.pacing.lag = 0.0, 3.21

    assert "as fast as possible   3.2 s behind" in drawn(host)


def test_table_is_no_longer_than_the_terminal():
    """Of a large fleet, the first robots and the number of the others are shown."""
    robots = [f"r{i}@{i},0" for i in range(100)]
    simulator = Simulator(load_world("scenario1", add_robots=robots).world)
    host = SimpleNamespace(simulator=simulator, pacing=SimpleNamespace(real_time_factor=1.0, lag=0.0))

    text = drawn(host)
    assert 29 == len(text.splitlines())
    assert "… and 76 more" in text


def test_table_looks_again_when_the_robot_moved_meanwhile(host, monkeypatch):
    """A robot that changes while it is read is read again."""
    robot = host.simulator.robots["wall_e"]
    failures, there = [AttributeError], robot.pose()

    def pose(_robot):
        if failures:
            raise failures.pop()
        return there

    with monkeypatch.context() as patch:
        patch.setattr(type(robot), "pose", pose)
        text = drawn(host)

    assert ("515.00" in text, []) == (True, failures)


def test_table_wants_the_clock():
    """The time in the title advances between events."""
    goals = LastGoals()

    assert [Topic.CLOCK] == [topic for topic in Topic if goals.wants(topic)]


def test_live_table(host):
    """Log lines are printed above the table, and the last table stays."""
    console = Console(file=io.StringIO(), width=120, force_terminal=True)

    with HostTable(host, "scenario 1", LastGoals(), console) as table:
        table.refresh()
        table.print("[INFO] hello")

    text = console.file.getvalue()
    assert text.index("[INFO] hello") < text.rindex("wall_e")
