"""``hmrsim action``, with a simulator."""

from __future__ import annotations

import json

import pytest

from hmrsim.cli import main


def test_goal_by_an_alias(endpoint, capsys):
    """The original's name drives the robot; feedback ends with 0."""
    goal = "{pose: {pose: {position: {x: 512, y: 215}}}}"
    code = main(["action", "send-goal", "navigate_to_pose/wall_e", goal, "--feedback", "--json", "--connect", endpoint])

    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert 0 == code
    assert 0.0 == lines[-2]["feedback"]["distance_remaining"]
    assert "SUCCEEDED" == lines[-1]["status_name"]


def test_actions_are_listed_with_types(endpoint, capsys):
    """One name a line, and the type behind it."""
    code = main(["action", "list", "-t", "--connect", endpoint])

    lines = capsys.readouterr().out.splitlines()
    assert 0 == code
    assert "/wall_e/pickup [moveit_msgs/action/Pickup]" in lines
    assert "/wall_e/grab [moveit_msgs/action/Pickup]" in lines


def test_actions_as_json(endpoint, capsys):
    """Programs get one list."""
    main(["action", "list", "--json", "--connect", endpoint])

    assert {
        "name": "/wall_e/drop",
        "type": "moveit_msgs/action/Place",
        "robot": "wall_e",
        "action": "place",
    } in json.loads(capsys.readouterr().out)


def test_info_of_an_action(endpoint, capsys):
    """The output has the type, the robots, the aliases, the fields and an example."""
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
    assert "Example: hmrsim action send-goal /wall_e/pickup '{target_name: parcel}'" == lines[-1]


def test_info_as_json(endpoint, capsys):
    """Programs get fields and their types."""
    main(["action", "info", "wall_e/wait", "--json", "--connect", endpoint])

    assert {"time": "builtin_interfaces/msg/Duration"} == json.loads(capsys.readouterr().out)["goal"]


@pytest.mark.parametrize(
    "arguments", [["action", "info", "/hal/wait"], ["topic", "echo", "/wall_e/smell"]], ids=" ".join
)
def test_unknown_names_are_1(arguments, endpoint, capsys):
    """An unknown name is an error that lists the known names."""
    code = main([*arguments, "--connect", endpoint])

    captured = capsys.readouterr()
    assert (1, "") == (code, captured.out)
    assert "wall_e" in captured.err
