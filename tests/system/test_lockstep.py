"""Lockstep between real processes, at any load, and with participants that crash."""

from __future__ import annotations

import hashlib
import json
import signal
from itertools import cycle, islice
from pathlib import Path

import pytest

CONTROLLER = Path(__file__).with_name("controller.py")
ROBOTS = ("wall_e", "eve", "burn_e", "m_o")
NAMES = ("ann", "bob", "cyd")


@pytest.fixture
def lockstep(start, tmp_path):
    """Return the function that serves the hospital in lockstep: process, endpoint and the path of its trace."""

    def run(*arguments, **env):
        trace = tmp_path / "trace.jsonl"
        options = ("--clock", "lockstep", "--listen", "tcp/127.0.0.1:0", "--trace", trace, *arguments)
        process = start("hmrsim", "run", "hospital", *options, env=env)
        ready = process.line().split()
        if ready[:1] != ["ready"]:
            raise AssertionError(f"not ready: {process.end()}")
        return process, ready[1], trace

    return run


@pytest.fixture
def control(start):
    """Return the function that starts a controller of some robots."""

    def run(endpoint, name, robots, *arguments, **env):
        return start("python", CONTROLLER, endpoint, name, ",".join(robots), *arguments, env=env)

    return run


@pytest.fixture
def perturbed(start, lockstep, control):
    """Return the function that lets controllers share four robots, on a busy machine or not, and returns the trace."""

    def run(number, controllers, *, busy):
        if busy:
            start("python", "-c", "while True: pass")
        simulator, endpoint, trace = lockstep("--participants", controllers, PYTHONHASHSEED=str(number))
        order = islice(cycle(range(controllers)), number, number + controllers)
        started = [
            control(endpoint, NAMES[i], ROBOTS[i::controllers], "--pause", 0.01, PYTHONHASHSEED=str(100 * number + i))
            for i in order
        ]
        assert [0] * controllers == [each.end()[0] for each in started]
        assert 0 == simulator.end(signal.SIGTERM)[0]
        return trace

    return run


@pytest.fixture
def replayed(command):
    """Return the function that replays a trace and returns exit code and outcome."""

    def run(trace):
        code, out, err = command("hmrsim", "replay", trace, "--json")
        return code, json.loads(out) if out else err

    return run


def lines(trace):
    """Return the lines of a trace, complete or not."""
    return [json.loads(line) for line in trace.read_text().splitlines()]


def happened(trace, kind):
    return [line for line in lines(trace) if line["kind"] == kind]


@pytest.mark.parametrize(("controllers", "runs"), [(1, 2), (2, 3), (3, 2)])
def test_every_run_has_the_same_trace(perturbed, replayed, controllers, runs):
    traces = [perturbed(number, controllers, busy=number == runs - 1) for number in range(runs)]
    hashes = {hashlib.sha256(trace.read_bytes()).hexdigest() for trace in traces}
    code, outcome = replayed(traces[0])

    assert 1 == len(hashes)
    assert 20 < outcome["commands"]
    assert (0, True, True) == (code, outcome["identical"], outcome["complete"])


def test_time_continues_without_a_killed_participant(lockstep, control, replayed):
    simulator, endpoint, trace = lockstep("--participants", "ann,bob")
    ann, bob = control(endpoint, "ann", ROBOTS[:2], "--stall", 3), control(endpoint, "bob", ROBOTS[2:])
    ann.line_with("thinking")
    ann.end(signal.SIGKILL)
    bob.line_with("left")
    simulator.end(signal.SIGTERM)
    (dropped,) = happened(trace, "participant_dropped")

    assert ("ann", "its liveliness token is gone") == (dropped["participant"], dropped["why"])
    assert (0, True) == (replayed(trace)[0], replayed(trace)[1]["complete"])


def test_a_stalled_participant_is_dropped_and_may_join_again(lockstep, control):
    simulator, endpoint, trace = lockstep("--participants", 2, "--participant-timeout", 5)
    ann, bob = control(endpoint, "ann", ROBOTS[:2], "--stall", 3), control(endpoint, "bob", ROBOTS[2:])
    ann.line_with("thinking")
    ann.process.send_signal(signal.SIGSTOP)
    bob.line_with("left")
    ann.process.send_signal(signal.SIGCONT)
    refused = ann.line_with("refused")
    ann.line_with("left")
    simulator.end(signal.SIGTERM)

    assert "participant 'ann' was dropped" in refused
    assert "it has not asked to advance for more than 5 s" in refused
    assert ["ann"] == [line["participant"] for line in happened(trace, "participant_dropped")]
    assert ["ann", "bob", "ann"] == [line["participant"] for line in happened(trace, "participant_joined")]


def test_a_loss_can_end_the_run(lockstep, control):
    simulator, endpoint, trace = lockstep("--participants", 2, "--on-participant-loss", "end")
    ann, bob = control(endpoint, "ann", ROBOTS[:2], "--stall", 3), control(endpoint, "bob", ROBOTS[2:])
    ann.line_with("thinking")
    ann.end(signal.SIGKILL)
    code, out, _ = bob.end()

    assert (0, "end") == (code, out.splitlines()[-1])
    code, _, err = simulator.end()
    assert "the run has ended, as participant 'ann' was dropped" in err.splitlines()[-1]
    assert code == 1
    assert ["end"] == [line["kind"] for line in lines(trace)[-1:]]


def test_the_trace_of_a_killed_simulator_replays(lockstep, control, replayed):
    simulator, endpoint, trace = lockstep()
    ann = control(endpoint, "ann", ROBOTS, "--stall", 8)
    ann.line_with("thinking")
    simulator.end(signal.SIGKILL)
    code, outcome = replayed(trace)

    assert (0, True, False) == (code, outcome["identical"], outcome["complete"])
