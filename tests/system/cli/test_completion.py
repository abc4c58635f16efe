"""Completion, as a shell asks for it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import time

import pytest

from hmrsim.cli import main
from tests.patience import PATIENCE

needs_bash = pytest.mark.skipif(shutil.which("bash") is None, reason="bash, which completes files, is not installed")

NOBODY = "tcp/127.0.0.1:1"


SERVER = """
import json, os, sys
import bt_controller.__main__, bt_controller.cli, hmrsim.cli.completion, hmrsim.cli

PROGRAMS = {"hmrsim": hmrsim.cli.main, "bt-controller": bt_controller.__main__.main}
for line in sys.stdin:
    asked = json.loads(line)
    reader, writer = os.pipe()
    child = os.fork()
    if not child:
        os.environ.update(asked)
        for descriptor in (1, 9):
            os.dup2(os.open(os.devnull, os.O_WRONLY), descriptor)
        os.dup2(writer, 8)
        PROGRAMS[asked["COMP_LINE"].split()[0]]()
        os._exit(1)
    os.close(writer)
    with os.fdopen(reader) as said:
        words = said.read().split()
    print(json.dumps([words, os.waitpid(child, 0)[1]]), flush=True)
"""
"""Completes line after line, each in a process of its own that has everything loaded: shells start one each time."""


def asked(line, connect):
    """Return the environment in which argcomplete's shell functions request the last word of a line."""
    return {
        "_ARGCOMPLETE": "1",
        "_ARGCOMPLETE_IFS": "\n",
        "_ARGCOMPLETE_SUPPRESS_SPACE": "1",
        "COMP_TYPE": "9",
        "COMP_LINE": line,
        "COMP_POINT": str(len(line)),
        "HMRSIM_CONNECT": connect,
    }


@pytest.fixture(scope="module")
def complete():
    """Return the function that completes the last word of a line."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", SERVER], **pipes, text=True) as server:

        def ask(line, connect=NOBODY):
            server.stdin.write(json.dumps(asked(line, connect)) + "\n")
            server.stdin.flush()
            words, status = json.loads(server.stdout.readline())
            assert 0 == status
            return words

        yield ask
        _, err = server.communicate()
        assert "" == err


@pytest.mark.parametrize(("line", "words"), [("hmrsim ma", ["map"]), ("bt-controller ch", ["check"])])
def test_the_program_prints_only_words_when_completing(tmp_path, line, words):
    module = {"hmrsim": "hmrsim.cli", "bt-controller": "bt_controller"}[line.split()[0]]
    done = subprocess.run(
        ["/bin/sh", "-c", f'exec "{sys.executable}" -m {module} 8>&1 9>/dev/null 1>/dev/null 2>"{tmp_path}/err"'],
        env={**os.environ, **asked(line, NOBODY)},
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )

    assert (words, "") == (done.stdout.split(), (tmp_path / "err").read_text())


@needs_bash
@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("hmrsim ma", ["map"]),
        ("hmrsim map ", ["list", "new", "generate", "schema", "validate", "info", "plan", "convert", "render"]),
        ("hmrsim map info hosp", ["hospital", "hospital_fleet", "hospital_logistics"]),
        ("hmrsim run hosp", ["hospital", "hospital_fleet", "hospital_logistics"]),
        ("hmrsim map plan hospital wall", ["wall_e"]),
        ("hmrsim map plan hospital wall_e pharmacy_", ["pharmacy_door", "pharmacy_counter"]),
        ("hmrsim map plan hospital lab pharmacy --for e", ["eve"]),
        ("hmrsim map convert hospital x --to ", ["yaml", "json", "geojson"]),
        ("hmrsim map info tests/unit/hmrsim/world/data/ward.drawio --page ", ["Ward"]),
        ("hmrsim simulate --page ", []),
        ("hmrsim run hospital --page ", []),
        ("hmrsim run scenario1 --real-", ["--real-time-factor"]),
        ("hmrsim topic list --mode ", ["peer", "client", "router"]),
        ("hmrsim completion ", ["bash", "zsh", "fish"]),
        ("bt-controller ", ["run", "check", "coverage", "nodes"]),
        ("bt-controller run missions:patrol --per", ["--period"]),
    ],
)
def test_commands_options_and_names_of_the_given_world_need_no_simulator(complete, line, words):
    assert words == complete(line)


@pytest.mark.parametrize("line", ["hmrsim action info ", "hmrsim topic echo /", "hmrsim service call "])
def test_without_a_simulator_there_are_no_candidates_and_no_error(complete, line):
    assert [] == complete(line)


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("hmrsim action info /wall_e/p", ["/wall_e/pickup", "/wall_e/place"]),
        ("hmrsim action send-goal wall_e/gr", ["wall_e/grab"]),
        ("hmrsim topic echo /_world/cl", ["/_world/clock"]),
        ("hmrsim topic hz /wall_e/od", ["/wall_e/odom"]),
        ("hmrsim service call /_world/inf", ["/_world/info"]),
        ("bt-controller run missions:patrol --robot ", ["wall_e"]),
    ],
)
def test_names_come_from_the_running_simulator(complete, endpoint, line, words):
    end = time.monotonic() + PATIENCE
    while not (found := complete(line, endpoint)) and time.monotonic() < end:
        pass

    assert words == found


@needs_bash
def test_files_are_completed_beside_shipped_worlds(complete, tmp_path):
    (tmp_path / "mine.yaml").write_text("name: mine\n")
    (tmp_path / "mine.txt").write_text("")

    assert [f"{tmp_path}/mine.yaml"] == complete(f"hmrsim map info {tmp_path}/mi")


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_scripts_are_for_both_programs(shell, capsys):
    code = main(["completion", shell])

    out = capsys.readouterr().out
    assert 0 == code
    assert "hmrsim" in out
    assert "bt-controller" in out


@needs_bash
def test_bash_accepts_the_script(capsys):
    main(["completion", "bash"])
    script = capsys.readouterr().out + "complete -p hmrsim bt-controller\n"

    done = subprocess.run(["bash", "--norc"], input=script, capture_output=True, text=True, check=True)
    assert "" == done.stderr
    assert 2 == done.stdout.count("_python_argcomplete")
