"""How processes end: signals, taken ports, a simulation that dies of a bug."""

from __future__ import annotations

import json
import signal

import pytest


@pytest.fixture
def follow_goal(start):
    """Return the function that starts a client, and returns it when its goal is accepted."""

    def run(endpoint):
        order = ("/wall_e/navigate_to_pose", "{pose: {pose: {position: {x: 512, y: 215}}}}")
        client = start("hmrsim", "action", "send-goal", *order, env={"HMRSIM_CONNECT": endpoint})
        client.line_with("Goal accepted with ID")
        return client

    return run


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_the_simulator_with_0_and_every_goal_with_a_verdict(serve, follow_goal, number):
    """The client that follows a goal sees it ABORTED."""
    simulator, endpoint = serve("scenario1", "--real-time-factor", "0.05")
    client = follow_goal(endpoint)
    code, _, _ = simulator.end(number)
    client_code, out, err = client.end()

    assert 0 == code
    assert 1 == client_code
    assert "ABORTED" in out
    assert "Traceback" not in err


def test_a_port_that_is_taken_is_exit_code_2_with_one_line(serve, command):
    """The line names both options that would help."""
    _, endpoint = serve("scenario1")
    code, out, err = command("hmrsim", "run", "scenario1", "--listen", endpoint)

    assert (2, "") == (code, out)
    assert 1 == len(err.strip().splitlines())
    assert endpoint in err
    assert "--listen" in err
    assert "--connect" in err


def test_a_second_simulator_of_one_prefix_refuses_to_start(serve, command):
    """Also when it would listen elsewhere; another prefix is fine."""
    _, endpoint = serve("scenario1")
    code, _, err = command("hmrsim", "run", "scenario1", "--connect", endpoint)

    assert 2 == code
    assert "--prefix" in err


def test_no_simulator_is_exit_code_3(command):
    """The command exits within the timeout, with advice on what to start."""
    code, out, err = command("hmrsim", "action", "list", "--connect", "tcp/127.0.0.1:9", "--timeout", "0.5")

    assert (3, "") == (code, out)
    assert "hmrsim run" in err


def test_ctrl_c_while_following_a_goal_cancels_it(serve, follow_goal):
    """Exit code 130, and the goal is CANCELED."""
    simulator, endpoint = serve("scenario1", "--real-time-factor", "0.05")
    client = follow_goal(endpoint)
    code, _, _ = client.end(signal.SIGINT)
    _, _, log = simulator.end(signal.SIGTERM)

    assert 130 == code
    assert "navigate_to_pose CANCELED" in log


def test_a_client_that_is_killed_leaves_the_others_served(serve, start, command):
    """Its goal goes on, without a client that waits for it."""
    _, endpoint = serve("scenario1", "--real-time-factor", "0.05")
    client = start(
        "hmrsim", "action", "send-goal", "/wall_e/wait", "{time: {sec: 1000}}", env={"HMRSIM_CONNECT": endpoint}
    )
    client.line_with("Goal accepted with ID")
    client.end(signal.SIGKILL)
    code, out, _ = command("hmrsim", "action", "list", "--json", endpoint=endpoint)

    assert 0 == code
    assert "/wall_e/wait" in json.dumps(out)


def test_the_duration_ends_the_simulator(serve):
    """After so many simulated seconds, with 0."""
    simulator, _ = serve("scenario1", "--real-time-factor", "100", "--duration", "20")

    assert 0 == simulator.end()[0]
