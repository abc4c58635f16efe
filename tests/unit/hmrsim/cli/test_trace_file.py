"""The trace of a run in a file."""

from __future__ import annotations

import json

from hmrsim.cli.trace_file import TraceFile
from hmrsim.events.traffic import LaneOpened
from hmrsim.protocol.outputs import EventStamped
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from tests.shipped import shipped


def test_outputs_after_the_end_are_ignored(tmp_path):
    """Python may free the processes of robots after the file is closed, and they then leave their docks."""
    path, world, settings = tmp_path / "trace.jsonl", shipped("scenario1").world, RunSettings()
    file = TraceFile(path, world, settings)
    simulator = Simulator(world, settings, file.sinks)
    with file.opened(simulator):
        simulator.advance(1.0)
    complete = path.read_bytes()
    for sink in file.sinks:
        for _ in range(10_000):
            sink.emit(EventStamped(0, LaneOpened(("home", "lobby"))))

    assert complete == path.read_bytes()
    assert json.loads(complete.splitlines()[-1])["kind"] == "end"
