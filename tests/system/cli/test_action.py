"""``hmrsim action``, with a simulator."""

from __future__ import annotations

import json
import shlex

import pytest


def test_a_goal_by_an_alias_drives_the_robot(run):
    goal = "{pose: {pose: {position: {x: 512, y: 215}}}}"
    code, out, _ = run("action", "send-goal", "navigate_to_pose/wall_e", goal, "--feedback", "--json")

    lines = [json.loads(line) for line in out.splitlines()]
    assert (0, "SUCCEEDED") == (code, lines[-1]["status_name"])
    assert 0.0 == lines[-2]["feedback"]["distance_remaining"]


def test_actions_are_listed_with_types(run):
    code, out, _ = run("action", "list", "-t")

    assert 0 == code
    assert {"/wall_e/pickup [moveit_msgs/action/Pickup]", "/wall_e/grab [moveit_msgs/action/Pickup]"} <= {
        *out.splitlines()
    }


def test_actions_as_json(run):
    entry = {"name": "/wall_e/drop", "type": "moveit_msgs/action/Place", "robot": "wall_e", "action": "place"}

    assert entry in json.loads(run("action", "list", "--json")[1])


def test_info_has_type_robots_aliases_fields_and_an_example(run):
    code, out, _ = run("action", "info", "wall_e/grab")

    lines = out.splitlines()
    assert 0 == code
    assert [
        "Action: /wall_e/pickup",
        "Type: moveit_msgs/action/Pickup",
        "Robot: wall_e",
        "Aliases: /wall_e/grab",
        "Action servers: 1",
    ] == lines[:5]
    assert {"    target_name: string", "    possible_grasps: moveit_msgs/msg/Grasp[]"} < {*lines}
    assert "Example: hmrsim action send-goal /wall_e/pickup '{target_name: medicine}'" == lines[-1]


def test_info_lists_the_constants_of_result_and_feedback(run):
    lines = run("action", "info", "/wall_e/dock_robot")[1].splitlines()

    assert lines.index("Result:") < lines.index("    FAILED_TO_STAGE=903") < lines.index("Feedback:")
    assert lines.index("Feedback:") < lines.index("    NAV_TO_STAGING_POSE=1")


@pytest.mark.parametrize("action", ["compute_path_to_pose", "compute_route", "pickup"])
def test_the_example_has_names_of_the_running_world(action, run):
    _, out, _ = run("action", "info", f"/wall_e/{action}")
    _, *words = shlex.split(out.splitlines()[-1].removeprefix("Example: "))

    assert ["action", "send-goal", f"/wall_e/{action}"] == words[:3]
    assert json.loads(run(*words, "--json")[1])["accepted"]


def test_a_goal_can_name_a_place(run):
    code, out, _ = run("action", "send-goal", "/wall_e/compute_path_to_pose", "{goal: ward}", "--json")

    end = json.loads(out)["result"]["path"]["poses"][-1]["pose"]["position"]
    assert (0, 100.0, 215.0) == (code, end["x"], end["y"])


def test_an_unknown_place_exits_with_1_and_a_suggestion(run):
    code, _, err = run("action", "send-goal", "/wall_e/navigate_to_pose", "{pose: wards}")

    assert (1, "hmrsim: goal: pose: no place 'wards'; did you mean 'ward'?\n") == (code, err)


def test_info_as_json(run):
    goal = json.loads(run("action", "info", "wall_e/wait", "--json")[1])["goal"]

    assert {"time": "builtin_interfaces/msg/Duration"} == goal


@pytest.mark.parametrize(
    "arguments", [["action", "info", "/hal/wait"], ["topic", "echo", "/wall_e/smell"]], ids=" ".join
)
def test_an_unknown_name_exits_with_1_and_the_known_ones(arguments, run):
    code, out, err = run(*arguments)

    assert (1, "", True) == (code, out, "wall_e" in err)
