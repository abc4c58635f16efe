"""An independent client of ROS 2's wire, ``zenoh-ros2-sdk``, runs scenario 1 and its failures."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from tests.paths import ROOT
from tests.system.ros2.processes import simulator

SCRIPT = Path(__file__).with_name("sdk_client.py")
SUCCEEDED, CANCELED, ABORTED = 4, 5, 6


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Return the SDK's findings by step, from one run for all tests."""
    world = yaml.safe_load((ROOT / "maps" / "scenario1.yaml").read_text())
    world["robots"]["wall_e"]["components"]["battery"] = {"capacity": 1e6, "initial_charge": 5e5}
    with simulator(world, "--real-time-factor", 10) as running:
        words = [sys.executable, SCRIPT, running.port]
        client = subprocess.run(words, capture_output=True, text=True, check=False, cwd=tmp_path_factory.mktemp("sdk"))
        assert 0 == client.returncode, (client.stdout, client.stderr, running.log.read_text())
        assert 0 == running.end()
    lines = [json.loads(line) for line in client.stdout.splitlines()]
    return {line.pop("what"): line for line in lines}


def test_services_are_discovered_with_their_types(told):
    action = "nav2_msgs/action/NavigateToPose"
    name = "/wall_e/navigate_to_pose/_action"

    assert [
        [f"{name}/cancel_goal", "action_msgs/srv/CancelGoal"],
        [f"{name}/get_result", f"{action}_GetResult"],
        [f"{name}/send_goal", f"{action}_SendGoal"],
    ] == told["services"]["found"]


@pytest.mark.parametrize(("step", "code"), [("to the medicine", 0), ("grab", 1), ("to the patient", 0), ("drop", 1)])
def test_each_step_succeeds(told, step, code):
    assert {"accepted": True, "stamped": True, "status": SUCCEEDED, "error_code": code} == told[step]


def test_the_remaining_distance_falls_to_zero(told):
    distances = told["feedback"]["distances"]

    assert sorted(distances, reverse=True) == distances
    assert 0.0 == distances[-1] < distances[0]


def test_status_is_received(told):
    assert told["status"]["of_the_drive"] in ([2, SUCCEEDED], [1, 2, SUCCEEDED])


def test_battery_is_received(told):
    assert {"percentage": 0.5, "present": True, "whose": "wall_e"} == told["battery"]


@pytest.mark.parametrize("goal", ["a goal without an id", "a goal with the id of another"])
def test_invalid_goals_are_rejected(told, goal):
    assert {"accepted": False} == told[goal]


def test_a_cancel_returns_the_id_and_ends_the_goal(told):
    assert {"code": 0, "its_own": True, "status": CANCELED} == told["a cancel"]


@pytest.mark.parametrize(
    ("cancel", "code"),
    [("a cancel that can't be read", 1), ("a cancel of one that nobody knows", 2), ("a cancel of one that is over", 3)],
)
def test_a_cancel_without_effect_has_its_code(told, cancel, code):
    assert {"code": code, "goals": 0} == told[cancel]


@pytest.mark.parametrize(("goal", "code"), [("to nowhere", 208), ("drop nothing", -19)])
def test_an_unreachable_goal_is_accepted_and_aborted_with_a_reason(told, goal, code):
    assert {"accepted": True, "stamped": True, "status": ABORTED, "error_code": code} == told[goal]


def test_the_result_of_an_unknown_goal_comes_at_once_without_a_status(told):
    assert {"status": 0} == told["no such goal"]


def test_a_result_request_is_held_and_answered_with_its_sequence_number(told):
    assert {"status": SUCCEEDED, "sequence": 7, "its_own": True} == told["a held result"]
