"""Recordings of the small world, and processes that make some."""

from __future__ import annotations

import pytest

from hmrsim.cli.record import rosout
from hmrsim.protocol.time import TimeState
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.sink import RecordingSink
from hmrsim_zenoh.recording.writer import RecordingFile
from tests import processes
from tests.simulation import simulate

STATE = TimeState(0.0, "realtime", 1.0, False, 0, (), (), 0.0)


def recorded(file, world=None, *, rate=10.0):
    """Return a recorded simulation and its sink."""
    made = []

    def recording(simulator):
        made.append(RecordingSink(simulator, Recorder(file, rosout), lambda: STATE, clock_rate=rate))
        return made

    run = simulate(world, watchers=recording, clock_rate=rate)
    return run, made[0]


def record_to(path, *commands, until=10.0, world=None, services=()):
    """Record commands, each with its time, and services, each with the time until which to go on; return the file."""
    with RecordingFile(path, reproducible=True) as file:
        simulated, sink = recorded(file, world)
        simulated(*commands, until=until)
        for service, request, later in services:
            simulated.ask(service, request)
            simulated.simulator.advance(later)
        sink.close()
    return path


@pytest.fixture
def record(tmp_path):
    """Return the function that records commands, each with its time, and returns the file."""
    return lambda *commands, path=None, **options: record_to(path or tmp_path / "run.mcap", *commands, **options)


@pytest.fixture
def start():
    """Return the function that starts hmrsim as a process; what still runs at the end of the test is killed."""
    with processes.killed_at_the_end() as run:
        yield run
