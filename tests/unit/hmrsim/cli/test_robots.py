"""The list of robots, and their live table."""

from __future__ import annotations

import io
from types import SimpleNamespace

import pytest
from rich.console import Console

from hmrsim.cli.robot import rows
from hmrsim.cli.robot_table import LastGoals, host_table
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
    return SimpleNamespace(
        simulator=Simulator(load_world("scenario1").world), pacing=SimpleNamespace(real_time_factor=2.0, lag=0.0)
    )


def drawn(host, *events, width=120, height=30):
    console = Console(file=io.StringIO(), width=width, height=height)
    goals = LastGoals()
    table = host_table(host, "scenario 1", goals, console)
    for event in events:
        goals.emit(event)
    console.print(table.table())
    return console.file.getvalue()


def ended(status, result):
    return GoalChanged(1, "wall_e", "navigate_to_pose", "1" * 32, status, result=result)


def test_a_robot_at_rest_has_a_position(host):
    text = drawn(host)

    assert "scenario 1   0.0 s   at 2 x" in text
    assert ["wall_e", "carrier", "515.00", "80.00", "0.00", "-"] == text.splitlines()[3].split()


def test_a_driving_robot_has_action_and_distance(host):
    host.simulator.submit(SendGoal("wall_e", "navigate_to_pose", MEDICINE_ROOM))
    host.simulator.advance(1.0)

    (row,) = [line for line in drawn(host).splitlines() if "wall_e" in line]
    assert "navigate_to_pose" in row
    assert "232.00" in row


def test_table_shows_the_carried_item(host):
    host.simulator.submit(SendGoal("wall_e", "navigate_to_pose", MEDICINE_ROOM))
    host.simulator.run()
    host.simulator.submit(SendGoal("wall_e", "pickup", Pickup.Goal(target_name="medicine")))
    host.simulator.run()

    assert " medicine " in drawn(host)


def test_table_shows_how_the_last_goal_ended(host):
    done = ended(GoalStatus.SUCCEEDED, NavigateToPose.Result())
    failed = ended(GoalStatus.ABORTED, NavigateToPose.Result(error_code=208, error_msg="no way"))

    assert "SUCCEEDED navigate_to_pose" in drawn(host, failed, done)
    assert "ABORTED: no way" in drawn(host, done, failed)


def test_a_failed_goal_is_red(host):
    console = Console(file=io.StringIO(), width=120, force_terminal=True, color_system="standard")
    goals = LastGoals()
    table = host_table(host, "scenario 1", goals, console)
    goals.emit(ended(GoalStatus.ABORTED, NavigateToPose.Result(error_code=208, error_msg="no way")))
    console.print(table.table())

    assert "\x1b[31mABORTED: no way" in console.file.getvalue()


@pytest.mark.parametrize("width", [20, 40, 80, 120])
def test_an_echoed_ctrl_c_does_not_wrap(host, width):
    """A wrapped line would keep the next table from replacing this one."""
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
def test_narrow_terminals_hide_columns(host, width, headings):
    lines = drawn(host, width=width).splitlines()

    assert headings.split() == lines[1].split()
    assert 4 == len(lines)


def test_the_title_has_the_lag(host):
    host.pacing.real_time_factor, host.pacing.lag = 0.0, 3.21

    assert "as fast as possible   3.2 s behind" in drawn(host)


def test_a_large_fleet_is_cut_to_the_terminal():
    robots = [f"r{i}@{i},0" for i in range(100)]
    simulator = Simulator(load_world("scenario1", add_robots=robots).world)
    host = SimpleNamespace(simulator=simulator, pacing=SimpleNamespace(real_time_factor=1.0, lag=0.0))

    text = drawn(host)
    assert 29 == len(text.splitlines())
    assert "… and 76 more" in text


def test_a_robot_that_changes_while_read_is_read_again(host, monkeypatch):
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


def test_the_title_advances_between_events():
    goals = LastGoals()

    assert [Topic.CLOCK] == [topic for topic in Topic if goals.wants(topic)]


def test_log_lines_are_above_the_last_table(host):
    console = Console(file=io.StringIO(), width=120, force_terminal=True)

    with host_table(host, "scenario 1", LastGoals(), console) as table:
        table.refresh()
        table.print("[INFO] hello")

    text = console.file.getvalue()
    assert text.index("[INFO] hello") < text.rindex("wall_e")


ROBOT = {
    "name": "mocha",
    "type": None,
    "pose": [1.0, 2.5, 0.0],
    "battery": None,
    "goals": [],
    "ailments": {},
    "holds": [],
    "dock": None,
    "connected": True,
    "cause": {"robot": "mocha", "kind": "idle", "text": "mocha is idle at bay: it has had no goal yet"},
}
LATTE = {
    **ROBOT,
    "name": "latte",
    "cause": {"robot": "latte", "kind": "works", "text": "latte executes wait at counter"},
}


def state(**robot):
    (*_, state), _ = rows({"robots": [{**ROBOT, **robot}, LATTE]})
    return state


def test_missing_values_are_dashes():
    idle = "idle at bay: it has had no goal yet"
    assert [("mocha", "-", "(1, 2.5)", "-", idle)] == list(rows({"robots": [ROBOT]}))


def test_a_robot_that_holds_something_is_idle():
    assert "holds parcel, idle at bay: it has had no goal yet" == state(holds=["parcel"])


def test_an_idle_robot_has_the_error_of_its_last_goal():
    """Another robot that waits for it has the error, too."""
    goal = {"action": "navigate_to_pose", "status": 6, "result": {"error_code": 208, "error_msg": "door is jammed"}}
    cause = {"robot": "latte", "kind": "robots", "text": "latte has waited at hall for mocha", "next": "mocha"}
    scene = {"robots": [{**ROBOT, "goals": [goal]}, {**LATTE, "cause": cause}]}
    text = "idle at bay: it has had no goal yet; its last goal failed: door is jammed"

    assert [text, f"has waited at hall for mocha; cause: mocha is {text}"] == [state for *_, state in rows(scene)]


def test_a_robot_that_is_out_of_service_has_the_reason():
    cause = {"robot": "mocha", "kind": "disabled", "text": "mocha is out of service at bay: its battery is empty"}

    told = state(ailments=["battery_empty"], cause=cause)
    assert "battery_empty, out of service at bay: its battery is empty" == told


def test_a_goal_takes_the_place_of_idle():
    assert "pickup, holds parcel" == state(holds=["parcel"], goals=[{"action": "pickup", "status": 2}])


@pytest.mark.parametrize(
    ("battery", "text"),
    [
        ({"percentage": 0.5, "charging": True}, "charging at plug"),
        ({"percentage": 1.0, "charging": False}, "docked at plug"),
        (None, "docked at plug"),
    ],
)
def test_a_docked_robot_may_be_charging(battery, text):
    cause = {"robot": "mocha", "kind": "docked", "text": "mocha is charging in 'plug'"}
    assert text == state(dock="plug", battery=battery, cause=cause)


def test_the_state_names_the_cause_of_a_wait():
    cause = {
        "robot": "mocha",
        "kind": "queue",
        "text": "mocha has queued for 'charger', taken by latte",
        "next": "latte",
    }
    assert "dock_robot, has queued for 'charger', taken by latte; cause: latte executes wait at counter" == state(
        goals=[{"action": "dock_robot", "status": 2}], cause=cause
    )


def test_the_state_names_the_obstacle():
    cause = {"robot": "mocha", "kind": "obstacle", "text": "mocha has waited at bay: kitchen is locked"}
    assert "has waited at bay: kitchen is locked" == state(cause=cause)
