"""Simulators for commands that need one."""

from __future__ import annotations

import subprocess

import pytest

from hmrsim.cli import main
from tests import processes

FREE_PORT = ("--listen", "tcp/127.0.0.1:0")


@pytest.fixture
def start():
    """Return the function that starts hmrsim as a process, which is killed at the end of the test."""
    with processes.killed_at_the_end() as run:
        yield run


@pytest.fixture(scope="module")
def endpoint():
    """Return the endpoint of a simulator of scenario 1, shared by the tests of a module."""
    words = ("run", "scenario1", "--real-time-factor", "10", *FREE_PORT)
    with processes.start("hmrsim", *words, stderr=subprocess.DEVNULL) as process:
        yield process.stdout.readline().split()[1]
        process.kill()


@pytest.fixture
def run(endpoint, capsys):
    """Return the function that runs a command at the simulator and returns exit code, output and errors."""

    def run(*words):
        code = main([*words, "--connect", endpoint])
        return code, *capsys.readouterr()

    return run
