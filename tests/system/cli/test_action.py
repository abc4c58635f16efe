"""``hmrsim action``, with a simulator."""

from __future__ import annotations

import json
import shlex

import pytest

from hmrsim.cli import main


def test_a_goal_by_an_alias_drives_the_robot(endpoint, capsys):
    goal = "{pose: {pose: {position: {x: 512, y: 215}}}}"
    code = main(["action", "send-goal", "navigate_to_pose/wall_e", goal, "--feedback", "--json", "--connect", endpoint])

    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert 0 == code
    assert 0.0 == lines[-2]["feedback"]["distance_remaining"]
    assert "SUCCEEDED" == lines[-1]["status_name"]


def test_actions_are_listed_with_types(endpoint, capsys):
    code = main(["action", "list", "-t", "--connect", endpoint])

    lines = capsys.readouterr().out.splitlines()
    assert 0 == code
    assert "/wall_e/pickup [moveit_msgs/action/Pickup]" in lines
    assert "/wall_e/grab [moveit_msgs/action/Pickup]" in lines


def test_actions_as_json(endpoint, capsys):
    main(["action", "list", "--json", "--connect", endpoint])

    assert {
        "name": "/wall_e/drop",
        "type": "moveit_msgs/action/Place",
        "robot": "wall_e",
        "action": "place",
    } in json.loads(capsys.readouterr().out)


def test_info_has_type_robots_aliases_fields_and_an_example(endpoint, capsys):
    code = main(["action", "info", "wall_e/grab", "--connect", endpoint])

    lines = capsys.readouterr().out.splitlines()
    assert 0 == code
    assert [
        "Action: /wall_e/pickup",
        "Type: moveit_msgs/action/Pickup",
        "Robot: wall_e",
        "Aliases: /wall_e/grab",
        "Action servers: 1",
    ] == lines[:5]
    assert "    target_name: string" in lines
    assert "    possible_grasps: moveit_msgs/msg/Grasp[]" in lines
    assert "Example: hmrsim action send-goal /wall_e/pickup '{target_name: medicine}'" == lines[-1]


def test_info_lists_the_constants_of_result_and_feedback(endpoint, capsys):
    main(["action", "info", "/wall_e/dock_robot", "--connect", endpoint])
    lines = capsys.readouterr().out.splitlines()

    assert lines.index("Result:") < lines.index("    FAILED_TO_STAGE=903") < lines.index("Feedback:")
    assert lines.index("Feedback:") < lines.index("    NAV_TO_STAGING_POSE=1")


@pytest.mark.parametrize("action", ["compute_path_to_pose", "compute_route", "pickup"])
def test_the_example_has_names_of_the_running_world(action, endpoint, capsys):
    main(["action", "info", f"/wall_e/{action}", "--connect", endpoint])
    _, *words = shlex.split(capsys.readouterr().out.splitlines()[-1].removeprefix("Example: "))

    assert ["action", "send-goal", f"/wall_e/{action}"] == words[:3]
    main([*words, "--json", "--connect", endpoint])
    assert json.loads(capsys.readouterr().out)["accepted"]


def test_a_goal_can_name_a_place(endpoint, capsys):
    words = ["action", "send-goal", "/wall_e/compute_path_to_pose", "{goal: ward}", "--json"]
    code = main([*words, "--connect", endpoint])

    end = json.loads(capsys.readouterr().out)["result"]["path"]["poses"][-1]["pose"]["position"]
    assert 0 == code
    assert (100.0, 215.0) == (end["x"], end["y"])


def test_an_unknown_place_exits_with_1_and_a_suggestion(endpoint, capsys):
    code = main(["action", "send-goal", "/wall_e/navigate_to_pose", "{pose: wards}", "--connect", endpoint])

    assert 1 == code
    assert "hmrsim: goal: pose: no place 'wards'; did you mean 'ward'?\n" == capsys.readouterr().err


def test_info_as_json(endpoint, capsys):
    main(["action", "info", "wall_e/wait", "--json", "--connect", endpoint])

    assert {"time": "builtin_interfaces/msg/Duration"} == json.loads(capsys.readouterr().out)["goal"]


@pytest.mark.parametrize(
    "arguments", [["action", "info", "/hal/wait"], ["topic", "echo", "/wall_e/smell"]], ids=" ".join
)
def test_an_unknown_name_exits_with_1_and_the_known_ones(arguments, endpoint, capsys):
    code = main([*arguments, "--connect", endpoint])

    captured = capsys.readouterr()
    assert (1, "") == (code, captured.out)
    assert "wall_e" in captured.err
