"""``hmrsim service``, with a simulator."""

from __future__ import annotations

import json
import signal

import pytest
import yaml

from hmrsim.cli import main

GOAL_ID = "0123456789abcdef0123456789abcdef"
LONG_WAIT = f"{{goal_id: {GOAL_ID}, goal: {{time: {{sec: 100000}}}}}}"
SEND_GOAL = "/wall_e/wait/_action/send_goal"
GET_RESULT = "/wall_e/wait/_action/get_result"
EXECUTE = "/wall_e/wait/_action/execute"
CANCEL_GOAL = "/wall_e/wait/_action/cancel_goal"

NO_TEXT = "request: goal_id: expected a string (quote it if it looks like a number)"


@pytest.fixture
def call(run):
    """Return the function that calls a service and returns exit code, output and errors."""
    return lambda *words: run("service", "call", *words)


def test_services_are_listed_without_those_of_actions(run):
    code, out, _ = run("service", "list", "-t")

    assert 0 == code
    assert "/_world/info [hmrsim/WorldInfo]" in out.splitlines()
    assert "/_action/" not in out


def test_hidden_services_are_marked_in_json(run):
    entry = {"name": SEND_GOAL, "type": "nav2_msgs/action/Wait_SendGoal", "hidden": True}

    assert entry in json.loads(run("service", "list", "--include-hidden-services", "--json")[1])


def test_an_answer_as_yaml(call):
    code, out, _ = call("/_world/info")

    assert (0, "scenario 1") == (code, yaml.safe_load(out)["world"]["name"])


def test_an_answer_as_json_without_the_first_slash(call):
    code, out, _ = call("_world/info", "--json")

    assert (0, 1) == (code, json.loads(out)["contract"])


def test_an_action_can_be_used_by_its_services(call):
    sent = json.loads(call(SEND_GOAL, LONG_WAIT, "--json")[1])
    canceled = json.loads(call(CANCEL_GOAL, "--json")[1])
    result = json.loads(call(GET_RESULT, f"{{goal_id: {GOAL_ID}}}", "--json")[1])

    assert (True, [GOAL_ID], 5) == (
        sent["accepted"],
        [one["goal_id"] for one in canceled["goals_canceling"]],
        result["status"],
    )


def test_the_execute_service_returns_the_result(call):
    code, out, _ = call(EXECUTE, "{goal: {}}", "--json")

    assert (0, 4) == (code, json.loads(out)["status"])


@pytest.mark.parametrize("verb", ["send_goal", "execute"])
def test_a_rejected_goal_is_a_successful_call(call, verb):
    """This is the behavior of ROS 2."""
    code, out, _ = call(f"/nobody/wait/_action/{verb}", "{goal: {time: {sec: 1}}}", "--json")

    assert (0, "unknown_robot") == (code, json.loads(out)["reason"])


def test_the_type_may_be_given(call):
    code, out, _ = call(GET_RESULT, "nav2_msgs/action/Wait_GetResult", f"{{goal_id: {'a' * 32}}}", "--json")

    assert (0, 0) == (code, json.loads(out)["status"])


@pytest.mark.parametrize(
    ("words", "error"),
    [
        ((GET_RESULT, "{goal_id: 3, x: 1}"), f"{NO_TEXT}, got 3\nrequest: x: unknown field; known fields: goal_id\n"),
        ((GET_RESULT, "{goal_id: zz}"), "request: goal_id: goal id 'zz' is not a UUID"),
        ((SEND_GOAL, "{}"), "request: goal: required field is missing\n"),
        ((SEND_GOAL, "{goal: [1]}"), "request: goal: expected a mapping, got [1]\n"),
        ((SEND_GOAL, "{goal: {time: {sec: 1.5}}}"), "request: goal.time.sec: expected an integer, got 1.5\n"),
        ((SEND_GOAL, "{goal: {time: {s: 1}}}"), "request: goal.time.s: unknown field; known fields: sec, nanosec\n"),
        ((EXECUTE, "{goal: {time: {s: 1}}}"), "request: goal.time.s: unknown field; known fields: sec, nanosec\n"),
        ((EXECUTE, "{goal: {}, feedback: 1}"), "request: feedback: expected true or false, got 1\n"),
        ((CANCEL_GOAL, "{goal_info: {x: 1}}"), "request: goal_info.x: unknown field; known fields: goal_id, stamp\n"),
        (("/_world/info", "{x: 3}"), "request: x: unknown field; remove it\n"),
        ((GET_RESULT, "[1]"), "request: expected a mapping such as '{goal_id: …}', got [1]\n"),
        ((GET_RESULT, "{a: 1, a: 2}"), "request: a: "),
        ((GET_RESULT, "{a: .inf}"), "request: NaN and infinity are not valid JSON; expected finite numbers\n"),
        ((GET_RESULT, "a/b/C", "{}"), f"{GET_RESULT} is a nav2_msgs/action/Wait_GetResult, not a a/b/C\n"),
        (("/wall_e/*",), "'/wall_e/*' has a wildcard; expected the name of one service\n"),
        ((GET_RESULT, "{goal_id:", "a}"), "'{goal_id:' is not a service's type; if it is part of the request, quote"),
    ],
)
def test_invalid_requests_exit_with_2_and_a_line_for_each_error(call, words, error):
    code, out, err = call(*words)

    assert (2, "") == (code, out)
    assert err.startswith(error)


@pytest.mark.parametrize(
    ("name", "error"),
    [
        ("/_world/inf", "hmrsim: no service '/_world/inf'; did you mean '/_world/info'?"),
        ("/nobody", "hmrsim: no service '/nobody'; there are /_world/info, /_world/route_graph"),
        ("/wally/wait/_action/send_goal", "hmrsim: no robot 'wally'; did you mean 'wall_e'?\n"),
        ("/nobody/wait/_action/get_result", "hmrsim: no robot 'nobody'; there are: wall_e\n"),
        ("/wall_e/fly/_action/send_goal", "hmrsim: wall_e has no action 'fly'; it has: "),
        ("/wall_e/wait/_action/get_resul", "hmrsim: no service '/wall_e/wait/_action/get_resul'; did you mean "),
        ("/a//b", "hmrsim: no service '/a//b'; there are "),
    ],
)
def test_an_unknown_service_exits_with_1_and_the_known_ones(call, name, error):
    code, out, err = call(name)

    assert (1, "") == (code, out)
    assert err.startswith(error)


def test_ctrl_c_ends_the_wait_for_a_result(call, endpoint, start):
    goal_id = "f" * 32
    call(SEND_GOAL, LONG_WAIT.replace(GOAL_ID, goal_id))
    waiting = start("service", "call", GET_RESULT, f"{{goal_id: {goal_id}}}", "--connect", endpoint, "--log-level=info")
    waiting.stderr.readline()
    waiting.send_signal(signal.SIGINT)

    assert 130 == waiting.wait()


def test_a_killed_simulator_ends_the_wait_with_3(start):
    simulator = start("run", "scenario1", "--listen", "tcp/127.0.0.1:0")
    endpoint = simulator.stdout.readline().split()[1]
    main(["service", "call", SEND_GOAL, LONG_WAIT, "--connect", endpoint])
    waiting = start("service", "call", GET_RESULT, f"{{goal_id: {GOAL_ID}}}", "--connect", endpoint, "--log-level=info")
    waiting.stderr.readline()
    simulator.kill()
    waiting.communicate()

    assert 3 == waiting.returncode


def test_a_response_without_success_exits_with_1(call):
    code, out, _ = call("/_world/inject_fault", "{type: hiccup}")

    assert 1 == code
    assert "no fault type ''hiccup''" in out
    assert 0 == call("/_world/get_entities")[0]
