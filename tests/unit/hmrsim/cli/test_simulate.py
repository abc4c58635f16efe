"""``hmrsim simulate``: scripts in virtual time."""

from __future__ import annotations

import json

import pytest

from hmrsim import plugins
from hmrsim.cli import main
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
    """Return a world with one robot that has a script."""
    path = tmp_path / "rooms.yaml"
    path.write_text(ROOMS)
    return path


@pytest.fixture
def simulate(capsys):
    """Runs the command; returns its exit code, and what it printed."""

    def run(*arguments: object) -> tuple[int, str, str]:
        code = main(["simulate", *map(str, arguments)])
        printed = capsys.readouterr()
        return code, printed.out, printed.err

    return run


def test_the_summary_has_every_script(simulate, rooms):
    """Each script is a line, followed by the goals, the simulated time and the wall time."""
    code, out, _ = simulate(rooms)

    lines = out.splitlines()
    assert 0 == code
    assert ["wall_e", "4/4", "done", "16.000", "s"] == lines[1].split()
    assert "1 of 1 scripts done; goals: 4 SUCCEEDED" == lines[2]
    assert lines[3].startswith("16.000 simulated seconds in ")


def test_json_is_one_object(simulate, rooms):
    """JSON has the content of the table."""
    _, out, _ = simulate(rooms, "--json", "--seed", 5)

    summary = json.loads(out)
    assert (16.0, 5, {"SUCCEEDED": 4}) == (summary["sim_time"], summary["seed"], summary["goals"])
    assert [{"robot": "wall_e", "orders": 4, "done": 4, "state": "done", "error": "", "ended": 16.0}] == summary[
        "robots"
    ]


def test_a_script_that_fails_ends_with_1(simulate, rooms):
    """The summary names the order and the error."""
    rooms.write_text(ROOMS.replace("Grab medicine", "Grab anvil"))
    code, out, _ = simulate(rooms)

    assert 1 == code
    assert "'Grab anvil' ended ABORTED: 'anvil' is too heavy: 80 kg, the claw lifts 1 kg" in out
    assert "0 of 1 scripts done; goals: 1 ABORTED, 1 SUCCEEDED" in out


def test_a_script_that_is_not_done_in_time_ends_with_1(simulate, rooms):
    """The robot is still driving."""
    code, out, _ = simulate(rooms, "--duration", 5)

    assert 1 == code
    assert ["wall_e", "0/4", "running", "at", "'Go", "shelf'"] == out.splitlines()[1].split()
    assert "5.000 simulated seconds" in out


def test_a_world_without_scripts_says_so(simulate, rooms):
    """A note says that nothing was done."""
    rooms.write_text(ROOMS[: ROOMS.index(", script")] + "}\n")
    code, out, err = simulate(rooms)

    assert 0 == code
    assert "no robot has a script" in err
    assert "0 of 0 scripts done; goals: none" in out


def test_an_invalid_script_is_an_error(simulate, rooms):
    """The error has file, line, value and what is expected."""
    rooms.write_text(ROOMS.replace("Go shelf", "Go shelv"))
    code, out, err = simulate(rooms)

    assert (2, "") == (code, out)
    assert (f"{rooms}:7: robots.wall_e.script.0: no waypoint, place or dock 'shelv'; did you mean 'shelf'?\n") == err


def test_robots_and_items_can_be_added(simulate, rooms):
    """``--robot`` and ``--item`` add to the world."""
    code, _, _ = simulate(rooms, "--robot", "burn_e@3,2:fetcher", "--item", "letter@3,2.1")

    assert 0 == code


def test_goals_are_logged_on_request(simulate, rooms):
    """Each goal's acceptance and end, and each event, is a line on stderr; the summary alone is on stdout."""
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


def test_it_ends_with_the_last_script(simulate, rooms):
    """The duration is an upper limit."""
    code, out, _ = simulate(rooms, "--duration", 600)

    assert 0 == code
    assert "16.000 simulated seconds" in out


def test_a_strict_run_needs_all_plugins(simulate, rooms, monkeypatch):
    """A plugin that can't be loaded is an error of one line; nothing runs, and no trace is written."""
    monkeypatch.setattr(plugins, "_left_out", [PluginError("dance: can't be imported: oops")])
    trace = rooms.with_name("trace.jsonl")

    assert (1, "", "hmrsim: dance: can't be imported: oops\n") == simulate(rooms, "--strict", "--trace", trace)
    assert not trace.exists()
    assert 0 == simulate(rooms)[0]
