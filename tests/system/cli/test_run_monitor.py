"""``hmrsim run --monitor`` watches properties while the world is served."""

from __future__ import annotations

import json
from argparse import Namespace

import pytest

from hmrsim.cli import main
from hmrsim.cli.check import check_trace
from hmrsim_zenoh.recording import Recording

FREE_PORT = ("--listen", "tcp/127.0.0.1:0")
WORLD = {
    "waypoints": {"home": [0, 0], "shelf": [3, 0]},
    "lanes": [["home", "shelf"]],
    "robots": {"eve": {"at": "home", "script": ["Go shelf"]}},
}


@pytest.fixture
def run(tmp_path):
    """Return the function that drives a robot to the shelf under properties."""

    def serve(properties):
        (tmp_path / "world.yaml").write_text(json.dumps(WORLD))
        (tmp_path / "properties.yaml").write_text(json.dumps({"properties": properties}))
        files = ("--trace", str(tmp_path / "run.jsonl"), "--record", str(tmp_path / "run.mcap"))
        watched = ("--monitor", str(tmp_path / "properties.yaml"))
        speed = ("--duration", "5", "--real-time-factor", "20")
        return main(["run", str(tmp_path / "world.yaml"), *watched, *speed, *files, *FREE_PORT])

    return serve


def test_a_violation_is_logged_and_makes_the_exit_code_1(run, capfd):
    code = run({"away": {"never": {"robot": "eve", "at": "shelf"}}})

    lines = [line for line in capfd.readouterr().err.splitlines() if "[ERROR]" in line]
    assert (1, ["sim 3.000", "the property away is violated at 2 s: eve is at shelf"]) == (
        code,
        lines[0].split(" | ")[1:],
    )


def test_a_violation_is_recorded_and_not_traced(run, tmp_path):
    """A trace must not depend on its watchers."""
    run({"away": {"never": {"robot": "eve", "at": "shelf"}}})

    recorded = [event for event in Recording(tmp_path / "run.mcap").events() if event["kind"] == "property_violated"]
    assert ([("away", "eve", "eve is at shelf")], False) == (
        [(event["property"], event["subject"], event["reason"]) for event in recorded],
        "property_violated" in (tmp_path / "run.jsonl").read_text(),
    )


def test_checks_of_trace_and_recording_find_the_violation(run, tmp_path, capsys):
    run({"away": {"never": {"robot": "eve", "at": "shelf"}}})
    found = []
    for name in ("run.jsonl", "run.mcap"):
        capsys.readouterr()
        args = Namespace(trace=tmp_path / name, properties=tmp_path / "properties.yaml", json=True, log_level="error")
        code = check_trace(args)
        said = json.loads(capsys.readouterr().out)["violations"]
        found.append((code, [(each["property"], round(each["at"], 3)) for each in said]))

    assert [(1, [("away", 2.0)])] * 2 == found


def test_reports_of_trace_and_recording_are_equal(run, tmp_path, capsys):
    run({})
    capsys.readouterr()
    told = []
    for name in ("run.jsonl", "run.mcap"):
        assert 0 == main(["report", str(tmp_path / name), "--json"])
        told.append(json.loads(capsys.readouterr().out))
    assert 2 == main(["report", str(tmp_path / "run.mcap"), "--section", "1"])

    assert told[0]["robots"] == told[1]["robots"]
    assert "no section 1: a recording has none" in capsys.readouterr().err


def test_a_run_without_a_violation_is_a_success(run):
    """Undecided properties of a stopped run are no failure."""
    assert 0 == run({"away": {"never": {"robot": "eve", "is": "waiting"}}, "back": {"eventually": {"event": "picked"}}})


def test_properties_about_missing_entities_exit_with_2(run, capsys):
    code = run({"away": {"never": {"robot": "eva", "at": "shelf"}}})

    assert (2, True) == (code, "no robot 'eva'; did you mean 'eve'?" in capsys.readouterr().err)
