"""``hmrsim action send-goal``, without a network."""

from __future__ import annotations

import json
import os
import signal
from contextlib import contextmanager

import pytest

from hmrsim.cli import action, main
from hmrsim.interfaces.builtin_interfaces import Duration
from hmrsim.interfaces.nav2_msgs import Wait
from hmrsim.protocol.goal import GoalStatus
from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.client.link import Link
from hmrsim_zenoh.errors import GoalRejectedError, RequestError, SimulatorGone, SimulatorNotFound
from tests.fake_connection import FakeConnection

INFO = {"robots": [{"name": "wall_e", "actions": ["wait"]}], "aliases": {"wall_e/rest": "wall_e/wait"}}
GOAL_ID = "0123456789abcdef" * 2


@pytest.fixture(autouse=True)
def client(monkeypatch):
    """Return the connection of the command's client; goals succeed at once unless a test says otherwise."""
    fake = FakeConnection()
    fake.ordered = True
    fake.robot = lambda goal: goal.succeed()

    @contextmanager
    def connected(_args, _role, **_options):
        with Client(session=fake, clock="realtime") as client:
            yield client, INFO

    monkeypatch.setattr(action, "connected", connected)
    monkeypatch.setattr(Link, "next_goal_id", lambda _link: GOAL_ID)
    return fake


@pytest.fixture
def send(capsys):
    """Return the function that sends a goal and returns exit code, output and errors."""

    def run(*arguments, name="/wall_e/wait"):
        code = main(["action", "send-goal", name, *arguments])
        return code, *capsys.readouterr()

    return run


def test_a_goal_prints_like_ros2_action_send_goal(client, send):
    code, out, _ = send("{time: {sec: 2}}")

    assert 0 == code
    assert [Wait.Goal(time=Duration(sec=2))] == [goal.goal for goal in client.goals]
    assert out.startswith(f"Goal accepted with ID: {GOAL_ID}\n\nResult:\n    total_elapsed_time:\n")
    assert out.endswith("\n\nGoal finished with status: SUCCEEDED\n")


@pytest.mark.parametrize("words", [[], ["nav2_msgs/action/Wait"]])
def test_a_missing_goal_is_an_error_with_an_example(client, words, send):
    error = "/wall_e/wait: the goal is missing; give it as YAML, such as '{time: {sec: 2}}'\n"

    assert (2, "", error) == send(*words)
    assert [] == client.goals


def test_empty_fields_of_a_result_are_not_printed(send):
    assert "error_msg" not in send("{}")[1]


def test_feedback_comes_between_acceptance_and_result(client, send):

    def then(goal):
        goal.accept()
        goal.feed(time_left=Duration(sec=2))
        goal.feed(time_left=Duration(sec=0))
        goal.succeed()

    client.robot = then
    _, out, _ = send("{}", "--feedback")

    headings = [line for line in out.splitlines() if line and not line.startswith(" ")]
    assert ["Feedback:", "Feedback:", "Result:", "Goal finished with status: SUCCEEDED"] == headings[1:]
    assert "Feedback:\n    time_left:\n      sec: 2\n      nanosec: 0\n\n" in out


def test_feedback_takes_one_line_on_a_terminal_unless_verbose(client, send, monkeypatch):
    """A drive of a minute has hundreds of samples."""
    monkeypatch.setattr("sys.stdout.isatty", lambda: True)
    client.robot = lambda goal: (goal.accept(), goal.feed(time_left=Duration(sec=2)), goal.succeed())

    assert "Feedback: time_left 2.0 s\n" in send("{}", "--feedback")[1]
    assert "Feedback:\n    time_left:\n      sec: 2\n" in send("{}", "--verbose")[1]


def test_without_the_option_the_client_does_not_subscribe_to_feedback(client, send):
    client.robot = lambda goal: (goal.accept(), goal.feed(time_left=Duration(sec=2)), goal.succeed())

    assert "Feedback" not in send("{}")[1]


@pytest.mark.parametrize("status", [GoalStatus.ABORTED, GoalStatus.CANCELED])
def test_a_goal_without_success_exits_with_1(client, status, send):
    client.robot = lambda goal: goal.end(status, goal.action.failure(701, ""))
    code, out, _ = send("{}")

    assert 1 == code
    assert "error_code: 701" in out
    assert out.endswith(f"Goal finished with status: {status.name}\n")


def test_a_rejected_goal_exits_with_1_and_the_reason(client, send):
    client.robot = lambda goal: goal.fail(GoalRejectedError("not_ready", 1, "no planner"))
    code, out, err = send("{}")

    assert (1, "") == (code, out)
    assert [
        "Goal was rejected: not_ready: no planner",
        "`hmrsim explain not_ready` says why that happens, and what to do",
    ] == err.splitlines()


def test_an_invalid_goal_exits_with_2_and_a_line_for_each_error(client, send):
    message = "Input should be a valid integer"
    error = RequestError("goal.time.sec: no", [{"field": "goal.time.sec", "message": message, "value": "x"}])
    client.robot = lambda goal: goal.fail(error)

    assert (2, "", "goal: time.sec: expected an integer, got 'x'\n") == send("{}")


@pytest.mark.parametrize("error", [SimulatorGone("it is gone"), SimulatorNotFound("no simulator answers")])
def test_a_missing_simulator_exits_with_3(client, error, send):
    client.robot = lambda goal: goal.fail(error)

    assert (3, "", f"hmrsim: {error}\n") == send("{}")


def test_json_has_a_line_for_each_feedback_and_then_the_outcome(client, send):
    client.robot = lambda goal: (goal.accept(), goal.feed(time_left=Duration(sec=1)), goal.succeed())
    code, out, _ = send("{}", "--feedback", "--json")

    feedback, outcome = map(json.loads, out.splitlines())
    assert 0 == code
    assert {"goal_id": GOAL_ID, "feedback": {"time_left": {"sec": 1, "nanosec": 0}}} == feedback
    assert (True, 4, "SUCCEEDED") == (outcome["accepted"], outcome["status"], outcome["status_name"])
    assert 0 == outcome["result"]["error_code"]


def test_json_of_a_rejection_has_the_fields_of_send_goal(client, send):
    client.robot = lambda goal: goal.fail(GoalRejectedError("busy", 1, "try later"))
    rejection = {"accepted": False, "goal_id": GOAL_ID, "reason": "busy", "error_code": 1, "error_msg": "try later"}

    assert rejection == json.loads(send("{}", "--json")[1])


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_ctrl_c_cancels_the_goal_waits_for_its_end_and_exits_with_130(client, number, code, send):

    def then(goal):
        goal.when_canceled = goal.end_canceled
        goal.accept()
        os.kill(os.getpid(), number)

    client.robot = then

    assert (code, "Canceling goal…\nGoal finished with status: CANCELED\n") == send("{}")[::2]


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_an_interrupted_program_still_prints_its_json(client, number, code, send):
    client.robot = lambda goal: (
        goal.accept(),
        setattr(goal, "when_canceled", goal.end_canceled),
        os.kill(os.getpid(), number),
    )

    found, out, _ = send("{}", "--json")
    outcome = json.loads(out)

    assert (code, True, GOAL_ID) == (found, outcome["accepted"], outcome["goal_id"])
    assert (5, "CANCELED") == (outcome["status"], outcome["status_name"])
    assert {"sec": 0, "nanosec": 0} == outcome["result"]["total_elapsed_time"]


@pytest.mark.parametrize(
    ("accepted", "status", "name"), [(True, 1, "ACCEPTED"), (None, 0, "UNKNOWN")], ids=["accepted", "not answered"]
)
def test_json_of_a_goal_with_unknown_end(client, send, accepted, status, name):

    def then(goal):
        goal.when_canceled = lambda: goal.fail(SimulatorGone("it is gone"))
        if accepted:
            goal.accept()
        os.kill(os.getpid(), signal.SIGINT)

    client.robot = then

    code, out, _ = send("{}", "--json")
    outcome = {"accepted": accepted, "goal_id": GOAL_ID, "status": status, "status_name": name, "result": None}

    assert (130, outcome) == (code, json.loads(out))


def test_json_of_a_goal_rejected_during_its_cancel(client, send):

    def then(goal):
        goal.when_canceled = lambda: goal.reject("busy", "try later")
        os.kill(os.getpid(), signal.SIGINT)

    client.robot = then

    code, out, _ = send("{}", "--json")
    outcome = json.loads(out)

    assert (130, False, "busy") == (code, outcome["accepted"], outcome["reason"])


def test_signal_handlers_are_restored(send):
    before = signal.getsignal(signal.SIGINT)
    send("{}")

    assert signal.getsignal(signal.SIGINT) is before


def test_the_type_and_an_alias_are_accepted(client, send):
    code, out, _ = send("nav2_msgs/action/Wait", "{}", name="wall_e/rest")

    assert (0, 1, True) == (code, len(client.goals), "SUCCEEDED" in out)


def test_the_goal_id_can_be_given_with_hyphens(client, send):
    assert f"ID: {'0' * 30}ab\n" in send("{}", "--goal-id", "00000000-0000-0000-0000-0000000000AB")[1]
    assert 1 == len(client.goals)


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (["{time: {sec: x}}"], "goal: time.sec: expected an integer, got 'x'"),
        (["nav2_msgs/action/Spin", "{}"], "/wall_e/wait is a nav2_msgs/action/Wait, not a nav2_msgs/action/Spin"),
        (
            ["{time:", "long}"],
            "'{time:' is not an action's type; if it is part of the goal, quote the goal: '{time: long}'",
        ),
        (["[2]"], "/wall_e/wait: the goal '[2]' is not a mapping; give it as YAML, such as '{time: {sec: 2}}'"),
        (["{}", "--goal-id", "xyz"], "--goal-id: goal id 'xyz' is not a UUID of 32 hex digits"),
    ],
)
def test_wrong_usage_exits_with_2_and_sends_nothing(client, arguments, line, send):
    assert (2, f"{line}\n", []) == (*send(*arguments)[::2], client.goals)
