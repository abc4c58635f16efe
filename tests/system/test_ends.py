"""Ends of processes: signals, taken ports, and a simulation that crashes."""

from __future__ import annotations

import json
import signal

import pytest


@pytest.fixture
def follow_goal(start):
    """Return the function that starts a client and waits until its goal is accepted."""

    def run(endpoint):
        order = ("/wall_e/navigate_to_pose", "{pose: {pose: {position: {x: 512, y: 215}}}}")
        client = start("hmrsim", "action", "send-goal", *order, env={"HMRSIM_CONNECT": endpoint})
        client.line_with("Goal accepted with ID")
        return client

    return run


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_simulator_with_0_and_aborts_every_goal(serve, follow_goal, number):
    simulator, endpoint = serve("scenario1", "--real-time-factor", "0.05")
    client = follow_goal(endpoint)
    code, _, _ = simulator.end(number)
    client_code, out, err = client.end()

    assert 0 == code
    assert 1 == client_code
    assert "ABORTED" in out
    assert "Traceback" not in err


def test_a_taken_port_exits_with_2_and_names_the_options(serve, command):
    _, endpoint = serve("scenario1")
    code, out, err = command("hmrsim", "run", "scenario1", "--listen", endpoint)

    assert (2, "") == (code, out)
    assert 1 == len(err.strip().splitlines())
    assert endpoint in err
    assert "--listen" in err
    assert "--connect" in err


def test_no_simulator_exits_with_3_within_the_timeout(command):
    code, out, err = command("hmrsim", "action", "list", "--connect", "tcp/127.0.0.1:9", "--timeout", "0.5")

    assert (3, "") == (code, out)
    assert "hmrsim run" in err


def test_ctrl_c_while_following_a_goal_cancels_it(serve, follow_goal):
    simulator, endpoint = serve("scenario1", "--real-time-factor", "0.05")
    client = follow_goal(endpoint)
    code, _, _ = client.end(signal.SIGINT)
    _, _, log = simulator.end(signal.SIGTERM)

    assert 130 == code
    assert "navigate_to_pose CANCELED" in log


def test_the_goal_of_a_killed_client_continues(serve, start, command):
    _, endpoint = serve("scenario1", "--real-time-factor", "0.05")
    client = start(
        "hmrsim", "action", "send-goal", "/wall_e/wait", "{time: {sec: 1000}}", env={"HMRSIM_CONNECT": endpoint}
    )
    client.line_with("Goal accepted with ID")
    client.end(signal.SIGKILL)
    code, out, _ = command("hmrsim", "action", "list", "--json", endpoint=endpoint)

    assert 0 == code
    assert "/wall_e/wait" in json.dumps(out)
