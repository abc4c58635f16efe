"""Simulators for commands to talk to."""

from __future__ import annotations

import subprocess
import sys

import pytest

FREE_PORT = ("--listen", "tcp/127.0.0.1:0")


@pytest.fixture
def start():
    """Return the function that starts hmrsim as a process; what still runs at the end of the test is killed."""
    started = []

    def run(*arguments):
        process = subprocess.Popen(
            [sys.executable, "-m", "hmrsim.cli", *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        started.append(process)
        return process

    yield run
    for process in started:
        with process:
            process.kill()


@pytest.fixture(scope="module")
def endpoint():
    """Return where a simulator of scenario 1 listens, one for all tests of a module."""
    words = [sys.executable, "-m", "hmrsim.cli", "run", "scenario1", "--real-time-factor", "10", *FREE_PORT]
    with subprocess.Popen(words, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        yield process.stdout.readline().split()[1]
        process.kill()
