"""Simulators as processes: many robots, a crash, and several simulators in one domain."""

from __future__ import annotations

import signal
import subprocess
import sys
from contextlib import contextmanager

import pytest

from tests.patience import PATIENCE
from tests.system.ros2.processes import free_endpoint, simulator
from tests.wire.ros2.client import SUCCEEDED, RosClient, Unanswered, goal_to, ros_action


def fleet(robots):
    """Return a world with this many robots, each at another place."""
    return {
        "name": "fleet",
        "waypoints": {f"p{number}": [number % 10, number // 10] for number in range(robots)},
        "lanes": [],
        "robots": {f"robot_{number}": {"at": f"p{number}"} for number in range(robots)},
    }


def test_a_hundred_robots_are_served_with_few_threads():
    names = ("wait", "follow_path", "compute_path_to_pose", "spin", "dock_robot")
    with simulator(fleet(100)) as running, RosClient(running.endpoint) as client:
        for number in range(100):
            client.graph.wait_for(*endpoints(f"/robot_{number}/navigate_to_pose", ros_action("navigate_to_pose")))
        clients = [client.action(f"/robot_{number}/{name}") for number in (0, 50, 99) for name in names]
        found = [one.wait() for one in clients]
        status, _ = client.action("/robot_99/wait").wait().do({"time": {"sec": 0}})

        assert clients == found
        assert SUCCEEDED == status
        assert 40 > running.threads


def endpoints(name, action):
    """Return kind, name and type of each endpoint of an action server."""
    services = {"send_goal": action.send_goal, "cancel_goal": action.cancel_goal, "get_result": action.get_result}
    topics = {"feedback": action.feedback, "status": action.status}
    return [
        *(("SS", f"{name}/_action/{verb}", type_.dds_name) for verb, type_ in services.items()),
        *(("MP", f"{name}/_action/{topic}", type_.dds_name) for topic, type_ in topics.items()),
    ]


def test_a_client_continues_with_a_restarted_simulator():
    endpoint = free_endpoint()
    with simulator("scenario1", endpoint=endpoint) as running, RosClient(endpoint) as client:
        drive = client.action("/wall_e/navigate_to_pose").wait()
        held = drive.send(goal_to(512, 215)).begin_result()
        running.end(signal.SIGKILL)
        client.graph.wait(lambda tokens: not any("bt_navigator" in token for token in tokens))
        with pytest.raises(Unanswered):
            held.result(PATIENCE)
        with simulator("scenario1", "--real-time-factor", 10, endpoint=endpoint):
            drive.wait()

            assert SUCCEEDED == drive.do(goal_to(512, 215))[0]


MEETING_AT = """
import sys
from hmrsim.cli import main
from hmrsim_zenoh.wire.options import DEFAULT_ENDPOINT, SessionOptions

endpoint, make = sys.argv.pop(1), SessionOptions.__init__
make.__defaults__ = tuple(endpoint if one == DEFAULT_ENDPOINT else one for one in make.__defaults__)
main()
"""
"""Starts ``hmrsim`` with the first argument as the endpoint at which processes meet, in place of port 7447."""


@contextmanager
def meeting(endpoint, world, *arguments, log):
    """Start a simulator as users do, without an endpoint to listen on."""
    command = [sys.executable, "-c", MEETING_AT, endpoint, "run", world, "--ros2", *map(str, arguments)]
    with log.open("w") as file, subprocess.Popen(command, stdout=subprocess.PIPE, stderr=file, text=True) as process:
        try:
            assert process.stdout.readline().startswith("ready "), log.read_text()
            yield process
        finally:
            process.kill()


@pytest.mark.parametrize("last", [signal.SIGTERM, signal.SIGKILL])
def test_a_simulator_warns_of_a_second_one_in_its_domain_and_survives_it(tmp_path, last):
    endpoint, logs = free_endpoint(), [tmp_path / "first", tmp_path / "second"]
    speed = ("--real-time-factor", 10)
    with (
        meeting(endpoint, "scenario1", *speed, log=logs[0]) as first,
        meeting(endpoint, "scenario1", *speed, "--prefix", "other", log=logs[1]),
    ):
        with RosClient(endpoint) as client:
            client.graph.wait(lambda tokens: 2 == sum(token.endswith("/%/hmrsim") for token in tokens))
        first.send_signal(last)
        first.wait()
        with RosClient(endpoint) as client:
            status, _ = client.action("/wall_e/wait").wait().do({"time": {"sec": 0}})

    assert SUCCEEDED == status
    assert "node /hmrsim publishes /clock, too: nodes with use_sim_time see time jump" in logs[1].read_text()
    assert f"the router has ended; listening on {endpoint} in its place" in logs[1].read_text()
