"""Processes that a command starts."""

from __future__ import annotations

import os
import queue
import select
import signal
import subprocess
import sys
from unittest.mock import MagicMock

import pytest

from hmrsim.cli import child
from hmrsim.cli.child import Child
from tests.patience import PATIENCE

PROGRAMS = """\
import os, signal, sys, time

def greet(arguments):
    print("hello", *arguments, sorted(name for name in os.environ if name.startswith("HMRSIM_")), flush=True)
    print("a complaint", file=sys.stderr, flush=True)
    return 7

def stubborn(arguments):
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    print("ready", flush=True)
    time.sleep(1000)

def wait(arguments):
    print(os.getpid(), flush=True)
    time.sleep(1000)
"""


@pytest.fixture
def start(tmp_path, monkeypatch):
    (tmp_path / "programs.py").write_text(PROGRAMS)
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join([str(tmp_path), *sys.path]))
    monkeypatch.setenv("HMRSIM_CONNECT", "tcp/nowhere:1")
    lines = queue.SimpleQueue()

    def run(name, *arguments):
        return Child(name, f"programs:{name}", arguments, lines.put), lines

    return run


def test_lines_arrive_before_the_exit_code(start):
    """HMRSIM variables are not passed to the child."""
    process, lines = start("greet", "world")
    with process:
        code = process.code(PATIENCE)

    assert ["hello world []", None] == [lines.get(timeout=PATIENCE) for _ in range(2)]
    assert (7, "a complaint") == (code, process.errors)


def test_errors_are_logged(start, caplog):
    with caplog.at_level("INFO", "hmrsim.cli.child"):
        process, _ = start("greet")
        with process:
            process.code(PATIENCE)

    assert ["greet: a complaint"] == caplog.messages


def test_a_child_that_ignores_sigterm_is_killed(start, monkeypatch):
    monkeypatch.setattr("hmrsim.cli.child._PATIENCE", 0.2)
    process, lines = start("stubborn")
    lines.get(timeout=PATIENCE)
    process.stop()

    assert -signal.SIGKILL == process.code(PATIENCE)


def test_a_child_that_takes_too_long_is_ended(start):
    process, lines = start("wait")
    lines.get(timeout=PATIENCE)

    with process:
        assert -signal.SIGTERM == process.code(0.1)


@pytest.mark.usefixtures("start")
def test_a_child_ends_with_its_parent():
    """The kernel ends the child if the parent is killed."""
    program = (
        "import sys; from hmrsim.cli.child import Child; "
        "Child('wait', 'programs:wait', [], lambda line: print(line, flush=True)); sys.stdin.read()"
    )
    with subprocess.Popen(
        [sys.executable, "-c", program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as parent:
        descriptor = os.pidfd_open(int(parent.stdout.readline()))
        parent.kill()
        parent.stdout.read()

    with os.fdopen(descriptor, "rb") as ended:
        assert select.select([ended], [], [], PATIENCE)[0] == [ended]


def test_an_orphan_ends_at_once():
    done = subprocess.run(
        [sys.executable, "-m", "hmrsim.cli.child", "1", "hmrsim.cli:main", "--version"],
        capture_output=True,
        text=True,
        check=False,
    )

    assert (1, "") == (done.returncode, done.stdout)


@pytest.mark.parametrize(("platform", "library"), [("linux", MagicMock()), ("darwin", object())])
def test_child_calls_the_main_function(capsys, monkeypatch, platform, library):
    """On macOS there is no prctl."""
    monkeypatch.setattr(child.ctypes, "CDLL", lambda _name: library)
    monkeypatch.setattr(child.sys, "platform", platform)

    code = child.main([str(os.getppid()), "hmrsim.cli:main", "--version"])

    assert (0, True) == (code, capsys.readouterr().out.startswith("hmrsim "))
