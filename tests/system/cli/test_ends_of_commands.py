"""Commands that are interrupted, or whose output is not read."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from hmrsim.cli import main

INTERRUPTED = """
import os, signal, sys
from hmrsim.cli import main
from hmrsim.robots.robot import Robot

Robot.plan_to = lambda *_: os.kill(os.getpid(), signal.SIGINT)
sys.exit(main(["simulate", sys.argv[1]]))
"""


def test_ctrl_c_ends_a_simulation_with_130():
    done = subprocess.run([sys.executable, "-c", INTERRUPTED, "zoo/door"], capture_output=True, text=True, check=False)

    assert (130, "", "traffic policy: priority\n") == (done.returncode, done.stdout, done.stderr)


def test_json_does_not_load_the_library_of_tables():
    program = (
        "import sys; from hmrsim.cli import main; main(['simulate', sys.argv[1], '--json']); "
        "print('rich' in sys.modules)"
    )

    done = subprocess.run([sys.executable, "-c", program, "zoo/door"], capture_output=True, text=True, check=True)

    assert "False" == done.stdout.splitlines()[-1]


def test_ctrl_c_during_imports_exits_with_130_without_a_traceback():
    program = (
        "import os, signal, sys; from hmrsim.cli import main; "
        "sys.addaudithook(lambda event, _: event == 'import' and os.kill(os.getpid(), signal.SIGINT)); "
        "sys.exit(main(['map']))"
    )

    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)

    assert (130, "") == (done.returncode, done.stderr)


def test_a_closed_pipe_is_not_a_failure():
    program = "from hmrsim.cli import main; raise SystemExit(main(['map', 'validate', 'nosuch', '--json']))"

    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        process.stdout.close()
        complaint = process.stderr.read()

    assert (0, b"") == (process.returncode, complaint)


@pytest.mark.parametrize("arguments", [["--help"], ["map", "info", "zoo/door"], ["completion", "bash"]], ids=" ".join)
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_a_full_disk_is_one_line_whatever_python_buffers(arguments, unbuffered):
    with Path("/dev/full").open("w", encoding="utf-8") as full:
        done = subprocess.run(
            [sys.executable, "-m", "hmrsim.cli", *arguments],
            stdout=full,
            stderr=subprocess.PIPE,
            env={**os.environ, "PYTHONUNBUFFERED": unbuffered},
            text=True,
            check=False,
        )

    assert (1, "hmrsim: can't write the output: no space left on device\n") == (done.returncode, done.stderr)


def test_closed_output_exits_with_1_and_one_line():
    command = f"{sys.executable} -m hmrsim.cli map info zoo/door >&-"

    done = subprocess.run(["/bin/sh", "-c", command], stderr=subprocess.PIPE, text=True, check=False)

    assert (1, "hmrsim: can't write the output: stdout is closed\n") == (done.returncode, done.stderr)


@pytest.mark.parametrize(
    "arguments", [["map", "convert", "zoo/door"], ["report", "x", "-o"], ["report", "x", "--csv"]], ids=" ".join
)
def test_a_file_name_that_is_too_long_is_one_line(arguments, capsys):
    name = "n" * 300 + ".yaml"

    code = main([*arguments, name])

    assert 2 == code
    (line,) = capsys.readouterr().err.splitlines()
    assert name in line
    assert line.endswith(": file name too long")
