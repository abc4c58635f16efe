"""Start and end of ``hmrsim run``."""

from __future__ import annotations

import json
import signal
import subprocess
import sys

import pytest

from hmrsim.cli import main
from hmrsim.timing.pacing import Pacing

FREE_PORT = ("--listen", "tcp/127.0.0.1:0")

SIGNALLED = """
import os, sys
from hmrsim.cli import main

_, module, number = sys.argv
sys.addaudithook(lambda event, args: event == "import" and args[0] == module and os.kill(os.getpid(), int(number)))
sys.exit(main(["run", "scenario1", "--listen", "tcp/127.0.0.1:0"]))
"""
"""Gets a signal when it begins to load a module."""


def test_the_first_line_has_endpoint_and_world(capsys):
    code = main(["run", "scenario1", "--duration", "0.1", *FREE_PORT])

    words = capsys.readouterr().out.split(maxsplit=2)
    assert 0 == code
    assert "ready" == words[0]
    assert words[1].startswith("tcp/127.0.0.1:")
    assert "world='scenario 1' robots=1\n" == words[2]


def test_ready_as_json(capsys):
    code = main(["run", "scenario1", "--duration", "0.1", "--json", "--robot", "eve@230,80:fetcher", *FREE_PORT])

    ready = json.loads(capsys.readouterr().out)
    assert 0 == code
    assert ready["ready"] is True
    assert 1 == len(ready["endpoints"])
    assert ["wall_e", "eve"] == ready["robots"]


def test_five_traffic_warnings_are_printed_and_the_rest_counted(tmp_path, capsys):
    path = tmp_path / "shelves.yaml"
    shelves = "".join(f"  shelf_{i}: {{at: [{i}, 0.5]}}\n" for i in range(1, 9))
    path.write_text(
        f"waypoints: {{a: [0, 0], b: [9, 0]}}\nlanes: [[a, b]]\nplaces:\n{shelves}"
        "robots: {ann: {at: a, base: {radius: 0.3}}, bob: {at: b, base: {radius: 0.3}}}\n"
    )
    code = main(["run", str(path), "--duration", "0.1", *FREE_PORT])

    *warnings, more = [line for line in capsys.readouterr().err.splitlines() if "warning" in line]
    assert 0 == code
    assert [f"{path}:{line}: warning: places.shelf_{line - 3}.at" for line in range(4, 9)] == [
        warning.partition(": (")[0] for warning in warnings
    ]
    assert "and 3 more traffic warnings; `hmrsim map validate --traffic WORLD` lists all" == more


def test_a_bug_in_the_simulation_exits_with_1_and_a_traceback(monkeypatch, capsys):

    def die(_pacing):
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr(Pacing, "run", die)
    code = main(["run", "scenario1", *FREE_PORT])

    assert 1 == code
    assert capsys.readouterr().err.endswith("ZeroDivisionError: a bug\n")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("module", ["hmrsim.program.command_line", "hmrsim.world", "hmrsim_zenoh.hosting.host"])
def test_a_signal_during_the_start_exits_with_0_silently(number, module):
    done = subprocess.run(
        [sys.executable, "-c", SIGNALLED, module, str(int(number))], capture_output=True, text=True, check=False
    )

    assert (0, "", "") == (done.returncode, done.stdout, done.stderr)


def test_a_duration_without_a_pace_is_explained(monkeypatch, capsys):
    """As fast as possible, an idle simulator waits for goals, however short its duration."""
    monkeypatch.setattr(Pacing, "run", lambda _pacing: None)
    main(["run", "scenario1", "--real-time-factor", "0", "--duration", "5", *FREE_PORT])

    first = capsys.readouterr().err.splitlines()[0]
    assert "--duration 5: as fast as possible, time advances only while robots are active" == first


def test_a_malformed_prefix_exits_with_2(capsys):
    code = main(["run", "scenario1", "--prefix", "a/*", *FREE_PORT])

    assert 2 == code
    assert "argument --prefix: prefix 'a/*' is not a plain key" in capsys.readouterr().err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_simulator_whose_stderr_is_full(start, number):
    process = start("run", "scenario1", *FREE_PORT)
    endpoint = process.stdout.readline().split()[1]
    fill = "{target_name: " + "x" * 30_000 + "}"
    for _ in range(4):
        main(["action", "send-goal", "/wall_e/pickup", fill, "--connect", endpoint])
    process.send_signal(number)

    assert 0 == process.wait()


def test_a_trace_and_a_recording_need_two_files(tmp_path, capsys):
    code = main(["run", "scenario1", "--trace", str(tmp_path / "a"), "--record", str(tmp_path / "b" / ".." / "a")])

    assert (2, True) == (code, "--trace and --record are both" in capsys.readouterr().err)
    assert [] == list(tmp_path.iterdir())
