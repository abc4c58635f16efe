"""``hmrsim run``: it begins, it ends."""

from __future__ import annotations

import json
import signal
import time

import pytest

from hmrsim.cli import main
from hmrsim.pacing import Pacing

pytestmark = pytest.mark.system

PATIENCE = 30.0
PROMISE = 2.0
FREE_PORT = ("--listen", "tcp/127.0.0.1:0")


def test_ready_line(capsys):
    """The first line says where it listens and what it runs; the end of its time is a success."""
    code = main(["run", "scenario1", "--duration", "0.1", *FREE_PORT])

    words = capsys.readouterr().out.split(maxsplit=2)
    assert 0 == code
    assert "ready" == words[0]
    assert words[1].startswith("tcp/127.0.0.1:")
    assert "world='scenario 1' robots=1\n" == words[2]


def test_ready_as_json(capsys):
    """For programs it is one JSON object."""
    code = main(["run", "scenario1", "--duration", "0.1", "--json", "--robot", "eve@230,80:fetcher", *FREE_PORT])

    ready = json.loads(capsys.readouterr().out)
    assert 0 == code
    assert ready["ready"] is True
    assert 1 == len(ready["endpoints"])
    assert ["wall_e", "eve"] == ready["robots"]


def test_a_simulation_that_dies_of_a_bug_is_1(monkeypatch, capsys):
    """The traceback goes to stderr."""

    def die(_pacing):
        raise ZeroDivisionError("a bug")

    monkeypatch.setattr(Pacing, "run", die)
    code = main(["run", "scenario1", *FREE_PORT])

    assert 1 == code
    assert capsys.readouterr().err.endswith("ZeroDivisionError: a bug\n")


def test_prefix_that_is_no_key_is_2(capsys):
    """A prefix with a wildcard is refused in one line."""
    code = main(["run", "scenario1", "--prefix", "a/*", *FREE_PORT])

    assert 2 == code
    assert capsys.readouterr().err.startswith("hmrsim: --prefix: prefix 'a/*' is not a plain key")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_at_once_though_nobody_reads_its_log(start, number):
    """A simulator whose stderr is full still ends with 0 within two seconds."""
    process = start("run", "scenario1", *FREE_PORT)
    endpoint = process.stdout.readline().split()[1]
    fill = "{target_name: " + "x" * 30_000 + "}"
    for _ in range(4):
        main(["action", "send-goal", "/wall_e/pickup", fill, "--connect", endpoint])
    begun = time.monotonic()
    process.send_signal(number)

    assert 0 == process.wait(PATIENCE)
    assert time.monotonic() - begun < PROMISE
