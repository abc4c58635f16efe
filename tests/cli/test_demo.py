"""``hmrsim demo``: both processes."""

from __future__ import annotations

import json
import signal

import pytest

from hmrsim.cli import demo, main

pytestmark = pytest.mark.system

PATIENCE = 30.0


def test_demo(capsys):
    """The whole fleet does its work; the log goes to stderr and the sum is one JSON object."""
    code = main(["demo", "--real-time-factor", "50", "--json"])

    captured = capsys.readouterr()
    done = json.loads(captured.out)
    moved = [item for robot in done["robots"].values() for item in robot["items_moved"]]
    assert 0 == code
    assert done["succeeded"] is True
    assert ["blood_samples", "linen", "medicine"] == sorted(moved)
    assert all(robot["failed"] == 0 for robot in done["robots"].values())
    assert " | world | wall_e   | picked up medicine\n" in captured.err
    assert " | tree  | wall_e   | Pick up medicine done\n" in captured.err
    assert "What the fleet did" in captured.err


def test_demo_whose_simulator_does_not_start(monkeypatch, capsys):
    """What the simulator says is told."""
    monkeypatch.setattr(demo, "_WORLD", "nosuch")
    code = main(["demo"])

    assert 1 == code
    assert "the simulator does not start; it says:\nnosuch: no such file" in capsys.readouterr().err


def test_demo_whose_mission_fails(monkeypatch, capsys):
    """The demo ends with 1 and says what the controller says."""
    monkeypatch.setattr(demo, "_TREE", "bt_controller.hospital:nosuch")
    code = main(["demo"])

    assert 1 == code
    assert "the mission failed; the controller says:" in capsys.readouterr().out


def test_demo_ends_its_children_on_ctrl_c(start):
    """Ctrl-C ends the demo with 130, and its output ends, too: no child holds it."""
    process = start("demo")
    for line in process.stdout:
        if "accepted" in line:
            break
    process.send_signal(signal.SIGINT)
    process.communicate(timeout=PATIENCE)

    assert 130 == process.returncode
