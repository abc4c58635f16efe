"""``hmrsim simulate``: scripts in virtual time."""

from __future__ import annotations

import json
from functools import partial

import pytest

from hmrsim import plugins
from hmrsim.errors import PluginError

ROOMS = """\
name: two rooms
waypoints: {home: [1, 2], shelf: [9, 2]}
lanes: [[home, shelf]]
items: {medicine: {at: [9, 2.3], weight: 0.2}, anvil: {at: [9, 2.3], weight: 80}}
robot_types: {nurse: {components: {claw: {max_weight: 1}}}}
robots:
  wall_e: {type: nurse, at: home, script: [Go shelf, Grab medicine, Go home, Drop medicine]}
  eve: {type: nurse, at: home}
"""


@pytest.fixture
def rooms(tmp_path):
    path = tmp_path / "rooms.yaml"
    path.write_text(ROOMS)
    return path


@pytest.fixture
def simulate(hmrsim):
    return partial(hmrsim, "simulate")


@pytest.mark.parametrize("options", [(), ("--duration", 600)], ids=["no limit", "a later limit"])
def test_the_summary_has_every_script(simulate, rooms, options):
    code, out, _ = simulate(rooms, *options)

    lines = out.splitlines()
    assert 0 == code
    assert ["wall_e", "4/4", "done", "16.000", "s"] == lines[1].split()
    assert "1 of 1 scripts done; goals: 4 SUCCEEDED" == lines[2]
    assert lines[3].startswith("16.000 simulated seconds in ")


def test_json_is_one_object(simulate, rooms):
    _, out, _ = simulate(rooms, "--json", "--seed", 5)

    summary = json.loads(out)
    assert (16.0, 5, {"SUCCEEDED": 4}) == (summary["sim_time"], summary["seed"], summary["goals"])
    assert [{"robot": "wall_e", "orders": 4, "done": 4, "state": "done", "error": "", "ended": 16.0}] == summary[
        "robots"
    ]


def test_a_failed_script_exits_with_1(simulate, rooms):
    rooms.write_text(ROOMS.replace("Grab medicine", "Grab anvil"))
    code, out, _ = simulate(rooms)

    assert 1 == code
    assert "'Grab anvil' ended ABORTED: 'anvil' is too heavy: 80 kg, the claw lifts 1 kg" in out
    assert "0 of 1 scripts done; goals: 1 ABORTED, 1 SUCCEEDED" in out


def test_an_unfinished_script_exits_with_1(simulate, rooms):
    code, out, _ = simulate(rooms, "--duration", 5)

    assert 1 == code
    assert ["wall_e", "0/4", "running", "at", "'Go", "shelf'"] == out.splitlines()[1].split()
    assert "5.000 simulated seconds" in out


def test_a_world_without_scripts_gets_a_note(simulate, rooms):
    rooms.write_text(ROOMS[: ROOMS.index(", script")] + "}\n")
    code, out, err = simulate(rooms)

    assert 0 == code
    assert "no robot has a script" in err
    assert "0 of 0 scripts done; goals: none" in out


def test_an_invalid_script_is_an_error(simulate, rooms):
    rooms.write_text(ROOMS.replace("Go shelf", "Go shelv"))
    code, out, err = simulate(rooms)

    assert (2, "") == (code, out)
    assert (f"{rooms}:7: robots.wall_e.script.0: no waypoint, place or dock 'shelv'; did you mean 'shelf'?\n") == err


def test_robots_and_items_can_be_added(simulate, rooms):
    code, _, _ = simulate(rooms, "--robot", "burn_e@3,2:fetcher", "--item", "letter@3,2.1")

    assert 0 == code


def test_goals_are_logged_on_request(simulate, rooms):
    """Log lines go to stderr, and only the summary to stdout."""
    _, out, err = simulate(rooms, "--log-level", "info", "--json")

    policy, *lines = err.splitlines()
    assert policy.startswith("traffic policy: free (default: robots pass through each other; ")
    assert "[INFO] sim 0.000 | wall_e navigate_to_pose accepted: (9, 2)" == lines[0]
    assert [
        "[INFO] sim 16.000 | wall_e place SUCCEEDED",
        "[INFO] sim 16.000 | wall_e finishes its script (4 of 4 orders)",
    ] == (lines[-2:])
    assert 11 == len(lines)
    assert 16.0 == json.loads(out)["sim_time"]


def test_a_strict_run_needs_all_plugins(simulate, rooms, monkeypatch):
    monkeypatch.setattr(plugins, "_left_out", [PluginError("dance: can't be imported: oops")])
    trace = rooms.with_name("trace.jsonl")

    assert (1, "", "hmrsim: dance: can't be imported: oops\n") == simulate(rooms, "--strict", "--trace", trace)
    assert not trace.exists()
    assert 0 == simulate(rooms)[0]
