"""Real processes that communicate over Zenoh on the loopback."""

from __future__ import annotations

import os
import signal

import pytest

from tests import processes
from tests.paths import ROOT


class Started:
    """A process of ours, with its output."""

    def __init__(self, arguments, *, env=None, cwd=ROOT):
        self.process = processes.start(*arguments, cwd=cwd, env={**os.environ, "PYTHONUNBUFFERED": "1", **(env or {})})

    def line(self):
        """Return the next line of its standard output."""
        return self.process.stdout.readline().rstrip("\n")

    def line_with(self, text):
        """Return the next line of its standard output that contains *text*."""
        for line in self.process.stdout:
            if text in line:
                return line.rstrip("\n")
        raise AssertionError(f"no line with {text!r}; standard error: {self.process.stderr.read()}")

    def end(self, number=None):
        """Send a signal if one is given, wait for the end, and return exit code, output and errors."""
        if number is not None:
            self.process.send_signal(number)
        out, err = self.process.communicate()
        return self.process.returncode, out, err


@pytest.fixture
def start():
    """Return the function that starts one of our commands, which is killed at the end of the test."""
    started = []

    def run(command, *arguments, env=None, cwd=ROOT):
        started.append(Started([command, *arguments], env=env, cwd=cwd))
        return started[-1]

    yield run
    for one in started:
        if one.process.poll() is None:
            one.process.kill()
        one.process.communicate()


@pytest.fixture
def serve(start):
    """Return the function that serves a world on a free port and returns the process and its endpoint."""

    def run(world, *arguments):
        process = start("hmrsim", "run", world, "--listen", "tcp/127.0.0.1:0", *arguments)
        ready = process.line().split()
        if ready[:1] != ["ready"]:
            raise AssertionError(f"not ready: {process.end()}")
        return process, ready[1]

    return run


@pytest.fixture
def command(start):
    """Return the function that runs a command to its end and returns exit code, output and errors."""

    def run(name, *arguments, endpoint=None, env=None):
        settings = {"HMRSIM_CONNECT": endpoint} if endpoint else {}
        return start(name, *arguments, env={**settings, **(env or {})}).end()

    return run


INTERRUPT = signal.SIGINT
TERMINATE = signal.SIGTERM
