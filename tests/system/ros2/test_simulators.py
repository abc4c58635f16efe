"""Simulators as processes: many robots, and a crash."""

from __future__ import annotations

import signal

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
