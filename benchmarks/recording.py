"""The cost of recording (--record) while all robots of the grid drive: processor time, messages and bytes."""

from __future__ import annotations

import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from benchmarks._fleet import SIDE, Wanderers, grid_world, plan_everything
from benchmarks._report import Row
from hmrsim.cli.record import rosout
from hmrsim.protocol.time import LOCKSTEP, TimeState
from hmrsim.settings.run import RunSettings
from hmrsim.simulation.simulator import Simulator
from hmrsim_zenoh.recording.recorder import Recorder
from hmrsim_zenoh.recording.sink import RecordingSink
from hmrsim_zenoh.recording.writer import RecordingFile

if TYPE_CHECKING:
    from hmrsim.protocol.outputs import Output

QUICK: dict[str, Any] = {"sizes": (10, 100), "seconds": 5.0}

_TIME = TimeState(0.0, LOCKSTEP, 1.0, False, 0, (), (), 0.0)
_RUSH = 2.0
"""Simulated seconds in which all begin, which are not measured."""
_MAX_MICROSECONDS = 20.0


class _Timed(RecordingSink):
    """A sink that knows for how long it held the simulation up, in processor time."""

    spent = 0.0

    def emit(self, output: Output) -> None:
        """Write an event."""
        began = time.thread_time()
        super().emit(output)
        self.spent += time.thread_time() - began


def run(*, sizes: Sequence[int] = (10, 100, 1000), seconds: float = 60.0, side: int = SIDE) -> list[Row]:
    """Return what it costs to record some simulated seconds, for each number of robots."""
    return [row for size in sizes for row in _of(size, seconds, side)]


def _of(robots: int, seconds: float, side: int) -> list[Row]:
    world = grid_world(robots, side=side)
    crowd, sinks = Wanderers(world), list[_Timed]()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.mcap")
        with RecordingFile(path, reproducible=True) as file:

            def recording(simulator: Simulator) -> list[_Timed]:
                sinks.append(_Timed(simulator, Recorder(file, rosout), lambda: _TIME, clock_rate=10.0))
                return sinks

            simulator = Simulator(world, RunSettings(keep_results=10), [crowd], watchers=recording)
            plan_everything(simulator)
            (sink,) = sinks
            crowd.start(simulator, simulator.robots)
            simulator.run(until=_RUSH)
            before, sink.spent = file.messages, 0.0
            simulator.run(until=_RUSH + seconds)
            messages = file.messages - before
            sink.close()
        megabytes = path.stat().st_size / 1e6 * 60 / (_RUSH + seconds)
    name = f"{robots:,} robots"
    return [
        Row(f"{name}: a message", sink.spent / messages * 1e6, "µs", at_most=_MAX_MICROSECONDS),
        Row(f"{name}: at real-time factor 1", sink.spent / seconds * 100, "% of a core"),
        Row(f"{name}: messages", messages / seconds, "messages/s"),
        Row(f"{name}: file", megabytes, "MB/minute"),
    ]
