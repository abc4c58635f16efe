"""``hmrsim demo``, with both of its processes."""

from __future__ import annotations

import json
import os
import re
import select
import signal
import socket
import subprocess
import sys
from pathlib import Path

import pytest

from hmrsim.cli import demo, main


@pytest.fixture(scope="module")
def told(tmp_path_factory):
    """Return the JSON objects of a demo in lockstep, its exit code, its log and its trace."""
    trace = tmp_path_factory.mktemp("demo") / "run.jsonl"
    options = ["--clock", "lockstep", "--json", "--log-level", "info", "--trace", str(trace)]
    process = subprocess.run(
        [sys.executable, "-m", "hmrsim.cli", "demo", *options], capture_output=True, text=True, check=False
    )
    return [json.loads(line) for line in process.stdout.splitlines()], process.returncode, process.stderr, trace


def test_the_whole_fleet_succeeds_and_the_totals_come_last(told):
    lines, code, *_ = told
    robots = lines[-1]["robots"]

    moved = sorted(item for robot in robots.values() for item in robot["items_moved"])
    assert (0, True) == (code, lines[-1]["succeeded"])
    assert ["blood_samples", "defibrillator", "linen", "meal", "medicine"] == moved
    assert [(name, 0) for name in robots] == [(name, robot["failed"]) for name, robot in robots.items()]
    assert len(robots) == 8


def test_demo_prints_cause_before_effect(told):
    traffic = ("undocked ", "waits", "takes ", "moves ")
    said = [line for line in told[0][:-1] if line["robot"] == "wall_e"]
    lines = [line for line in said if not line["text"].startswith(traffic)]

    assert [
        "Go to pharmacy begun",
        "navigate_to_pose accepted: (6, 18)",
        "navigate_to_pose SUCCEEDED",
        "Go to pharmacy done",
        "Pick up medicine begun",
        "pickup accepted: medicine",
        "picks up medicine",
        "pickup SUCCEEDED",
        "Pick up medicine done",
    ] == [line["text"] for line in lines[:9]]
    times = [line["sim_time"] or 0.0 for line in lines]
    assert sorted(times) == times


def test_demo_passes_on_the_log_of_its_processes(told):
    log = told[2]

    assert re.search(r"^\[INFO\] .* \| simulator: \[INFO\] .* wall_e navigate_to_pose accepted", log, re.MULTILINE)


def test_demo_without_a_terminal_prints_lines_and_a_table(told, capsys, tmp_path):
    trace = tmp_path / "run.jsonl"
    code = main(["demo", "--clock", "lockstep", "--trace", str(trace)])

    out = capsys.readouterr().out
    assert 0 == code
    assert " | tree  | wall_e   | Pick up medicine begun\n" in out
    assert " | world | wall_e   | pickup SUCCEEDED\n" in out
    times = [float(line.partition("|")[0].strip() or 0.0) for line in out.splitlines() if line.count(" | ") == 3]
    assert sorted(times) == times
    assert out.endswith("`hmrsim demo --view` shows the mission in the browser\n")
    assert "What the fleet did" in out
    assert "the mission succeeded: " in out
    assert told[-1].read_bytes() == trace.read_bytes()


def test_the_mission_has_obstacles(told):
    lines = [json.loads(line) for line in told[-1].read_text().splitlines()]
    happened = [line for line in lines if "stamp" in line]

    assert ["visitors", "wet_floor"] == [line["name"] for line in happened if line["kind"] == "fault_began"]
    assert ["m_o", "nan_e"] == [line["robot"] for line in happened if line["kind"] == "rerouted"]
    assert (14, 18) == (
        sum("is opening" in line.get("why", "") for line in happened if line["kind"] == "waiting"),
        sum("for" in line for line in happened if line["kind"] == "waiting"),
    )
    assert 247 == lines[-1]["stamp"]["sec"]


def test_demo_prints_why_its_simulator_does_not_start(monkeypatch, capsys):
    monkeypatch.setattr(demo, "_WORLD", "nosuch")
    code = main(["demo"])

    assert 1 == code
    assert re.search(r"the simulator does not start; it says:\n.*nosuch: no such file", capsys.readouterr().err)


def test_demo_reports_a_taken_port_of_the_page_at_once(capsys):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        code = main(["demo", "--view", str(taken.getsockname()[1])])

    assert (2, True) == (code, "is taken; name another with --view" in capsys.readouterr().err)


def test_demo_with_a_failed_mission_exits_with_1_and_its_error(monkeypatch, capsys):
    monkeypatch.setattr(demo, "_TREE", "bt_controller.examples.hospital:nosuch")
    code = main(["demo"])

    out = capsys.readouterr().out
    assert 1 == code
    assert "the mission failed: " in out
    assert re.search("the controller ended with 2; it says:\nbt-controller: .* has no 'nosuch'", out)
    assert "the simulator ended" not in out


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)])
def test_a_signal_ends_the_demo_and_both_processes(start, number, code):
    process = start("demo")
    for line in process.stdout:
        if "begun" in line:
            break
    children = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
    descriptors = [os.pidfd_open(int(child)) for child in children]
    process.send_signal(number)
    _, complaints = process.communicate()

    assert (code, 2) == (process.returncode, len(children))
    assert complaints == "interrupted; the simulator and the controller have ended\n"
    assert descriptors == select.select(descriptors, [], [], 0)[0]
    for descriptor in descriptors:
        os.close(descriptor)
