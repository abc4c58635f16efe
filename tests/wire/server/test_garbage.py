"""Clients leave no reference cycles behind, which only Python's rare full collections would free."""

from __future__ import annotations

import gc
import json

import pytest

from hmrsim_zenoh.client.client import Client
from hmrsim_zenoh.ros2.wires import RmwZenoh
from tests.patience import PATIENCE
from tests.served_world import served_world

TIMES = 5


@pytest.fixture
def ask():
    """Send requests to a simulator that serves JSON and ROS 2, while a client listens to everything."""
    with (
        served_world(wires=(RmwZenoh(),), real_time_factor=0, keep_results=1) as options,
        Client(options, clock="realtime") as client,
        Client(options, clock="realtime") as listener,
    ):
        listener.subscribe("**", lambda *_sample: None)
        yield lambda key, values: json.loads(client.get(f"hmrsim/{key}", PATIENCE, payload=json.dumps(values).encode()))


def goal(ask, number):
    """Execute a goal, which is forgotten for the next one."""
    goal_id = f"{number + 1:032x}"
    answer = ask("wall_e/wait/_action/send_goal", {"goal_id": goal_id, "goal": {"time": {"sec": 1}}})
    assert answer["accepted"], answer
    assert ask("wall_e/wait/_action/get_result", {"goal_id": goal_id})["status"] == 4


def guest(ask, number):
    """Spawn and delete a robot."""
    name = f"guest_{number}"
    pose = {"pose": {"position": {"x": 3.5, "y": 0.1 + 0.01 * number}}}
    answer = ask("_world/spawn_entity", {"name": name, "uri": "robot_type:nurse", "initial_pose": pose})
    assert answer["result"]["result"] == 1, answer
    assert ask("_world/delete_entity", {"entity": name})["result"]["result"] == 1


def fault(ask, number):
    """Close a lane for a while, so that routes are planned again."""
    request = {"type": "breakdown", "name": f"fault_{number}", "robot": "wall_e", "duration": 0.5}
    assert ask("_world/inject_fault", request)["result"]["result"] == 1


@pytest.mark.parametrize("deed", [goal, guest, fault])
def test_requests_leave_no_reference_cycles(ask, deed):
    for number in range(TIMES):
        deed(ask, number)
    gc.collect()
    gc.disable()
    # Garbage from threads of other tests in this process does not count.
    gc.freeze()
    try:
        for number in range(TIMES, 3 * TIMES):
            deed(ask, number)
        gc.set_debug(gc.DEBUG_SAVEALL)
        gc.collect()
        kinds = {type(each) for each in gc.garbage}
        ours = [kind for kind in kinds if kind.__module__.startswith(("hmrsim", "pydantic"))]
    finally:
        gc.set_debug(0)
        gc.garbage.clear()
        gc.unfreeze()
        gc.enable()

    assert not ours
